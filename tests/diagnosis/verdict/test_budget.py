"""The budget of the gap: shares by Shapley, by joint and by run; with the rest they add up to one."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import GAITS, bench, make_session, snake

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.diagnosis.verdict.budget import _orders, _Shares, _shares, by_share, of_causes, window_draws


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    effects = ["rate_limit:limit_rad_s=1.2,joints=3", "servo_offset:offset_deg=4,joints=1"]
    return diagnose(make_session(bench(3), effects), only=["rate_limit", "servo_offset"], quick=True)


def test_each_cause_carries_the_joint_that_it_is_on(found: Diagnosis) -> None:
    limit, offset = ([c.effect for c in found.causes].index(name) for name in ("rate_limit", "servo_offset"))
    entries = {entry.cause: entry for entry in found.shares_of("joint_angle")}
    assert set(entries) == {limit, offset, None}
    assert sum(entry.share for entry in entries.values()) == pytest.approx(1, abs=1e-3)
    assert entries[limit].by_joint == pytest.approx((0, None, 1), abs=0.01)
    assert entries[offset].by_joint == pytest.approx((1, None, 0), abs=0.01)
    assert entries[None].share < 0.01
    assert found.unexplained.share == entries[None].share
    for entry in entries.values():
        assert entry.ci95 is not None
        assert entry.ci95[0] <= entry.share <= entry.ci95[1]
    assert set(entries[limit].by_run) == set(found.closure.held_out_runs)
    slow = entries[offset].by_run["run_03.csv"]
    fast = entries[offset].by_run["run_01.csv"]
    assert slow is not None
    assert fast is not None
    assert slow > fast  # the slow gait never meets the limit


def test_causes_stand_in_the_order_of_what_they_carry(found: Diagnosis) -> None:
    entries = {entry.cause: entry.share for entry in found.budget}
    assert [entries[at] for at in range(len(found.causes))] == sorted(entries.values(), reverse=True)
    swapped = [
        entry.model_copy(update={"cause": 0 if entry.cause else 1}) for entry in found.budget
    ]  # the second carries most
    told, budget = by_share(found.causes, [*swapped, *found.budget_rest])
    assert told == found.causes[::-1]
    assert budget == (*found.budget, *found.budget_rest)
    over_ground = [entry.model_copy(update={"of": "ground"}) for entry in found.budget]
    assert by_share(found.causes, over_ground) == (found.causes, tuple(over_ground))


def test_the_budget_of_the_terms_becomes_that_of_the_causes(found: Diagnosis) -> None:
    of_terms = [*found.budget, *found.budget_rest]
    second, first, rest = of_causes(of_terms, [1, 0, None])  # the third cause is no term of the explanation
    assert (second.cause, first.cause, rest.cause) == (1, 0, None)
    assert [entry.share for entry in (second, first, rest)] == [entry.share for entry in of_terms]


def test_how_sure_a_cause_is_rests_on_what_it_carries(found: Diagnosis) -> None:
    for entry in found.budget:
        assert entry.cause is not None
        assert found.causes[entry.cause].evidence["share"] == entry.share


def test_what_two_causes_do_only_together_is_shared_in_half() -> None:
    """Either alone takes 1 of 10 away, both take 10."""
    squares = {frozenset(): 10.0, frozenset({0}): 9.0, frozenset({1}): 9.0, frozenset({0, 1}): 0.0}
    shares = _shares([0, 1], lambda c: np.array([squares[c]]), np.zeros(1), np.ones(1), seed=0)
    assert shares.of(np.ones(1, dtype=bool)) == pytest.approx([0.5, 0.5, 0.0])


def test_what_mends_another_cause_has_no_share_of_its_own() -> None:
    """A delay that is too long takes 4 of 10 away, the lag below the stated one that goes with it adds 6, both take 7;
    an offset takes 2 whatever the others do.
    """
    late = {frozenset(): 10.0, frozenset({0}): 6.0, frozenset({1}): 16.0, frozenset({0, 1}): 3.0}
    shares = _shares(
        [0, 1, 2], lambda c: np.array([late[c - {2}] - 2.0 * (2 in c)]), np.zeros(1), np.ones(1), seed=0
    )
    assert shares.of(np.ones(1, dtype=bool)) == pytest.approx([0.7, 0.0, 0.2, 0.1])


def test_where_there_is_no_gap_there_is_no_share() -> None:
    quiet = _Shares([0], np.array([[0.05]]), np.array([-0.02]), np.array([1.0]), np.ones(1))
    assert quiet.of(np.ones(1, dtype=bool)) is None
    assert quiet.entries("joint_angle", None, [], {}) == []


def test_many_causes_are_added_in_some_orders_and_back() -> None:
    assert len(_orders(3, 0)) == 6
    orders = _orders(5, 0)
    assert len(orders) == 8
    assert all(order[::-1] in orders for order in orders)


def test_windows_over_ground_are_drawn_within_their_run_and_lone_speeds_among_the_runs() -> None:
    run, lone = np.array([0, 0, 0, 1, 2, 3, 4]), np.array([False, False, False, False, True, True, True])
    draws = window_draws(run, lone, seed=1)
    assert draws is not None
    drawn = np.sort(run[draws], axis=1)
    assert (drawn[:, :4] == [0, 0, 0, 1]).all()
    assert ((drawn[:, 4:] >= 2) & (drawn[:, 4:] <= 4)).all()
    assert len({tuple(row) for row in drawn[:, 4:].tolist()}) == 10  # every choice of three out of three


def test_two_numbers_over_ground_give_no_interval() -> None:
    assert window_draws(np.array([0, 0]), np.array([False, False]), seed=1) is None
    assert window_draws(np.array([0, 1]), np.array([True, True]), seed=1) is None


def test_shares_over_ground_have_an_interval() -> None:
    session = make_session(snake(), ["ground_friction:ct_scale=3"], gaits=GAITS[:2], pose=True)
    found = diagnose(session, quick=True, only=["ground_friction"])
    of_friction, of_rest = found.shares_of("ground")
    ground = found.closure.ground
    assert ground is not None
    assert ground.closed == 1 - of_rest.share > 0.9
    assert ground.ci95 is not None
    assert of_rest.ci95 is not None
    assert ground.ci95 == (1 - of_rest.ci95[1], 1 - of_rest.ci95[0])
    first = found.to_mapping(first=True)["closure"]
    assert "ground" not in first
    assert not any("joint_angle_closed_beyond_tolerance" in step for step in first["steps"])
    assert of_friction.share > 0.9
    assert of_friction.share + of_rest.share == pytest.approx(1, abs=1e-3)
    for entry in (of_friction, of_rest):
        assert entry.ci95 is not None
        assert entry.ci95[0] <= entry.share <= entry.ci95[1]
