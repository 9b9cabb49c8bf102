"""Lost set-points in the place of what stood for them: that does not stay beside them as a cause that does nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, lossy_session, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import against_nominal, trial_at
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.random_loss import random_delay, with_random_loss
from snakebot.diagnosis.search.search import SearchResult
from snakebot.runlog import Session

DEAD_BAND = Term("deadband", None, (("hard", 0.0),))


def test_a_dead_band_that_only_stood_for_the_loss_goes() -> None:
    session = lossy_session(bench(3), 0.6)
    nominal, evidence = against_nominal(gather(prepare(session)))
    best = trial_at(evidence, Hypothesis((DEAD_BAND,)), np.array([0.4]))
    found = SearchResult(evidence, nominal, best, singles=(best,), rivals=((),), path=(nominal, best))
    library = usable_effects(evidence.data, over_ground=False)
    after = with_random_loss(evidence, library, found, quick=True)
    assert after.best.hypothesis.names == ("command_loss",)
    assert len(after.rivals) == 1
    assert after.path[0] is nominal


def test_what_is_there_beside_the_loss_stays() -> None:
    session = lossy_session(bench(3), 0.6, ["servo_offset:offset_deg=3"])
    nominal, evidence = against_nominal(gather(prepare(session)))
    best = trial_at(evidence, Hypothesis((Term("servo_offset", None), DEAD_BAND)), np.array([3.0, 0.4]))
    found = SearchResult(evidence, nominal, best, singles=(), rivals=((), ()), path=(nominal, best))
    library = usable_effects(evidence.data, over_ground=False)
    after = with_random_loss(evidence, library, found, quick=True)
    assert after.best.hypothesis.names == ("servo_offset", "command_loss")


@pytest.mark.parametrize(
    ("terms", "values", "left"),
    [
        ((Term("command_delay", None),), [0.012], ()),
        ((Term("servo_offset", None), Term("command_delay", None)), [3.0, 0.012], ("servo_offset",)),
    ],
)
def test_a_loss_that_may_not_be_named_is_no_delay_either(
    terms: tuple[Term, ...], values: list[float], left: tuple[str, ...]
) -> None:
    faults = ["servo_offset:offset_deg=3"] if left else []
    nominal, evidence = against_nominal(gather(prepare(lossy_session(bench(3), 0.6, faults))))
    best = trial_at(evidence, Hypothesis(terms), np.array(values))
    found = SearchResult(evidence, nominal, best, singles=(), rivals=((),) * len(terms), path=(nominal, best))
    library = usable_effects(evidence.data, over_ground=False, exclude=["command_loss"])
    after = with_random_loss(evidence, library, found, quick=True)
    assert after.best.hypothesis.names == left
    assert len(after.rivals) == len(left)
    assert after.seen_in_scatter


def test_joints_must_agree_on_a_random_delay() -> None:
    nominal, evidence = against_nominal(gather(prepare(make_session(bench(3)))))
    rng = np.random.default_rng(3)
    marks = [
        rng.normal(0.0, 0.02, (run.t_s.size, 1)) * np.gradient(reading, run.t_s, axis=0)
        for run, reading in zip(evidence.data.runs, nominal.readings, strict=True)
    ]
    shared = replace(nominal, left=marks)
    assert random_delay(evidence.data, evidence.floor, shared).share > 0.9
    of_one = replace(nominal, left=[mark * [0.0, 1.0, 0.0] for mark in marks])
    assert not random_delay(evidence.data, evidence.floor, of_one).evident
    # nor where that joint also moves most
    faster = [reading * [0.1, 1.0, 0.1] for reading in nominal.readings]
    mostly = replace(of_one, readings=faster)
    assert not random_delay(evidence.data, evidence.floor, mostly).evident


def test_one_joint_alone_agrees_with_nobody() -> None:
    nominal, evidence = against_nominal(gather(prepare(make_session(bench(1)))))
    rng = np.random.default_rng(3)
    for _ in range(20):  # the one joint is all there is: what is left beside it is rounding
        left = [rng.normal(0.0, 0.1, reading.shape) for reading in nominal.readings]
        assert random_delay(evidence.data, evidence.floor, replace(nominal, left=left)).share == 0.0


def test_what_nothing_tests_gives_way_to_lost_set_points() -> None:
    robot = bench(3)
    data = prepare(Session(robot, lossy_session(robot, 0.5).runs[:3]))
    nominal, evidence = against_nominal(gather(data))
    library = usable_effects(data, over_ground=False)
    nothing_held_out = replace(evidence, split=replace(evidence.split, folds=()))
    guess = SearchResult(nothing_held_out, nominal, nominal, (), (), (nominal,), untested=True)
    found = with_random_loss(evidence, library, guess, quick=True)
    assert found.best.hypothesis.names == ("command_loss",)
    assert not found.untested
    assert found.evidence.split.folds


def test_it_stays_where_none_are_lost() -> None:
    robot = bench(3)
    data = prepare(Session(robot, lossy_session(robot, 0.0).runs[:3]))
    nominal, evidence = against_nominal(gather(data))
    guess = SearchResult(evidence, nominal, nominal, (), (), (nominal,), untested=True)
    assert with_random_loss(evidence, usable_effects(data, over_ground=False), guess, quick=True) is guess
