"""Worn robots: what the label says is what is in them, and what an answer tells is scored as it stands."""

from typing import Any

import numpy as np
import pytest
from blind.faults import FAULTS
from blind.robot import Build, Parameters
from blind.worn import STAND_OUT, Bench, Part, shares
from blind.worn_kinds import KINDS, TOLERANCE, kind_of
from blind.worn_scores import dominant_named, share_errors, told_shares


class Additive(Bench):
    """A robot whose readings are sums: each effect writes its row of offsets."""

    def of(self, parameters: Parameters) -> Any:
        return np.outer(np.ones(4), parameters.joint("offset_rad"))


def offset_of(joint: int, rad: float) -> Part:
    def put_in(p: Parameters) -> None:
        p.joint("offset_rad")[joint - 1] += rad

    return Part(f"effect_{joint}", "servo", [joint], {}, (put_in,))


def test_shares_of_effects_that_add_up_are_those_of_shapley() -> None:
    bench = Additive(Parameters(), Build(), (), 0.0)
    # on joints of their own: the squares
    told, tolerance = shares(bench, [offset_of(1, 3.0), offset_of(2, 4.0)])
    assert told == pytest.approx([9 / 25, 16 / 25])
    assert tolerance == pytest.approx(0.0)
    # on the same joint, one against the other: 3 - 1 = 2; Shapley's values of |r|^2 - |r - sum|^2 by hand
    parts = [offset_of(1, 3.0), offset_of(1, -1.0)]
    by_hand = [((4 - 1) + (4 - (4 - 9))) / 2 / 4, ((4 - 9) + (4 - (4 - 1))) / 2 / 4]
    assert shares(bench, parts)[0] == pytest.approx(by_hand)
    assert sum(by_hand) == pytest.approx(1.0)


def test_what_a_healthy_robot_is_off_by_has_a_share_of_its_own() -> None:
    healthy = Parameters()
    healthy.joint("offset_rad")[0] = -1.0
    told, tolerance = shares(Additive(healthy, Build(), (), 0.0), [offset_of(1, 3.0)])
    by_hand = [((4 - 1) + (4 - (4 - 9))) / 2 / 4, ((4 - 9) + (4 - (4 - 1))) / 2 / 4]
    assert [*told, tolerance] == pytest.approx(by_hand)
    assert kind_of(TOLERANCE) == kind_of("servo_lag")


def test_all_that_may_stand_out_are_scaled_and_show_in_the_joints() -> None:
    for name in STAND_OUT:
        assert FAULTS[name].scaled
        assert FAULTS[name].known
        assert FAULTS[name].stage != "body"
        assert kind_of(name) in KINDS


def effect(name: str, share: float, dominant: bool = False) -> dict[str, Any]:
    return {"name": name, "share": share, "dominant": dominant}


def cause(name: str, *others: str) -> dict[str, Any]:
    return {"effect": name, "indistinguishable_from": list(others)}


LABEL = {"effects": [effect("backlash", 0.5, True), effect("servo_lag", 0.3), effect("command_delay", 0.1)]}


def test_the_dominant_fault_must_come_first() -> None:
    assert dominant_named(LABEL, {"causes": [cause("deadband", "backlash"), cause("servo_lag")]})
    assert not dominant_named(LABEL, {"causes": [cause("servo_lag"), cause("backlash")]})
    assert not dominant_named(LABEL, {"causes": []})
    assert not dominant_named(LABEL, None)
    two = {"effects": [effect("backlash", 0.4, True), effect("rate_limit", 0.35, True)]}
    assert dominant_named(two, {"causes": [cause("rate_limit")]})
    two["effects"][1]["share"] = 0.2
    assert not dominant_named(two, {"causes": [cause("rate_limit")]})


def test_shares_are_those_of_the_budget_or_of_the_steps() -> None:
    causes = [cause("second_order"), cause("deadband")]
    budget = [{"cause": 1, "share": 0.5}, {"cause": 0, "share": 0.42}]
    answer = {"causes": causes, "budget": budget, "closure": {"steps": []}}
    assert told_shares(answer) == pytest.approx({"late": 0.42, "play": 0.5})
    assert max(share_errors(LABEL, answer)) == pytest.approx(0.02)
    steps = [
        {"effect": "second_order", "joint_angle_closed": 0.7},
        {"effect": "deadband", "joint_angle_closed": 0.9},
    ]
    old = {"causes": causes, "closure": {"steps": steps}}
    assert told_shares(old) == pytest.approx({"late": 0.7, "play": 0.2})
    assert share_errors(LABEL, old) == pytest.approx([0.3, 0.3])
    assert share_errors(LABEL, None) == pytest.approx([0.4, 0.5])


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_worn_robot_has_what_its_label_says() -> None:
    from blind.cases import make_case

    first, again = (make_case("worn", 1, 2, 40) for _ in range(2))
    assert first.label == again.label
    standing = [e for e in first.label.effects if e.dominant]
    assert 1 <= len(standing) <= 2
    told = [e.share for e in first.label.effects]
    assert None not in told
    assert sum(share or 0.0 for share in told) == pytest.approx(1.0, abs=0.25)
    assert sum(e.share or 0.0 for e in standing) > 0.4
    lags = first.parameters.joint("lag_s")
    assert np.ptp(first.parameters.joint("play_rad")) > np.radians(0.1)
    assert lags.size == first.label.joints
