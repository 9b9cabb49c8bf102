"""One round of the search: what is fitted, held out and compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, nominal_trial, run_trial
from snakebot.diagnosis.search.acceptance import excess_as_fitted
from snakebot.diagnosis.search.candidate import added
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.outlook import promise
from snakebot.diagnosis.search.plainly import by_plainer_effects
from snakebot.diagnosis.search.rounds import explore
from snakebot.diagnosis.sizes import LITTLE
from snakebot.effects.registry import find_effect

pytestmark = pytest.mark.slow


def explored(effect: str) -> list[Trial]:
    evidence = gather(prepare(make_session(snake(), [effect])))
    library = usable_effects(evidence.data, over_ground=False)
    return list(explore(evidence, library, nominal_trial(evidence), lambda text, share: None).trials)


def named(trials: list[Trial], effect: str) -> list[Trial]:
    return [t for t in trials if t.hypothesis.names == (effect,)]


def test_what_a_rough_fit_takes_for_the_winner_in_more_words_is_held_out_too() -> None:
    """All joints bend: friction beside it comes out at zero, which only the full fit can say for sure."""
    trials = explored("compliance:stiffness_nm_rad=40")
    assert trials[0].hypothesis.names == ("compliance",)
    assert named(trials, "joint_friction")


@pytest.mark.parametrize("stiffness_nm_rad", [5, 15])
def test_a_joint_that_bends_by_many_degrees_is_found(stiffness_nm_rad: float) -> None:
    """The torques of the nominal motion are then far from those that bend it."""
    trials = explored(f"compliance:stiffness_nm_rad={stiffness_nm_rad},joints=2")
    assert trials[0].hypothesis.names == ("compliance",)
    assert trials[0].theta == pytest.approx([stiffness_nm_rad], rel=0.02)


def test_what_takes_most_of_the_gap_away_is_held_out_though_its_score_is_low() -> None:
    """The score would rather have a little of the gap of all joints than most of the far larger one of one joint."""
    worn = ["backlash:width_deg=2,loaded=1", "servo_offset:offset_deg=0.8"]
    evidence = gather(prepare(make_session(snake(), [*worn, "compliance:stiffness_nm_rad=7,joints=2"])))
    library = usable_effects(evidence.data, over_ground=False)
    loose = Hypothesis((Term("backlash", None, (("loaded", 1.0),)),))
    base = run_trial(evidence, loose, [np.array([2.0])])
    found = explore(evidence, library, base, lambda text, share: None)
    scoring = evidence.scoring
    first = max(found.fits, key=lambda fit: fit.fitted_score(scoring))
    most = min(found.fits, key=lambda fit: excess_as_fitted(scoring, fit, scoring.of_angles))
    assert most.hypothesis.terms[-1].joints == (2,)
    assert most.hypothesis.terms[-1].effect in ("compliance", "joint_friction")  # each a spring
    assert {first.hypothesis, most.hypothesis} <= {trial.hypothesis for trial in found.trials}


def test_a_joint_that_bends_among_play_and_offsets_is_told() -> None:
    """As dry friction of that joint beside offsets the half of it was explained, where the play stayed as it was first
    fitted alone.
    """
    worn = ["backlash:width_deg=2,loaded=1", "servo_offset:offset_deg=0.8"]
    found = diagnose(make_session(snake(), [*worn, "compliance:stiffness_nm_rad=7,joints=2"]), quick=True)
    causes = {cause.effect: cause for cause in found.causes}
    assert set(causes) == {"compliance", "backlash", "servo_offset"}
    assert causes["compliance"].joints == (2,)
    assert causes["compliance"].parameters["stiffness_nm_rad"].estimate == pytest.approx(7, rel=0.02)


def test_what_shows_in_a_few_speeds_over_ground_is_held_out_beside_what_shows_in_all_angles() -> None:
    """A speed a run weighs nothing beside hundreds of blocks of angles, but no effect of a joint accounts for it."""
    session = make_session(
        snake(),
        ["joint_friction:coulomb_nm=0.6,stiffness_nm_rad=20,joints=3", "slope:angle_deg=4"],
        pose=True,
        duration_s=10.0,
    )
    speeds = []
    for run in session.runs:
        assert run.pose is not None
        last = run.t_s >= run.t_s[-1] / 2
        way, time_s = run.pose[last, :2], np.ptp(run.t_s[last])
        speed = float(np.hypot(*(way[-1] - way[0])) / time_s)
        speeds.append(replace(run, pose=None, forward_speed_m_s=speed))
    evidence = gather(prepare(replace(session, runs=tuple(speeds))))
    library, nominal = usable_effects(evidence.data, over_ground=True), nominal_trial(evidence)
    assert gap_of(evidence.scoring, nominal.held_square).ground_significant
    trials = explore(evidence, library, nominal, lambda text, share: None).trials
    assert {"body", "servo"} <= {t.hypothesis.terms[-1].stage for t in trials}


@pytest.mark.parametrize("effect", ["backlash:width_deg=1,joints=2", "clock_drift:ppm=-3000"])
def test_what_looks_like_a_delay_of_another_size_or_sign_is_tried(effect: str) -> None:
    """A small play passes for a lag within tolerance, which the promise of a play must not reckon with twice."""
    trials = explored(effect)
    assert named(trials[:1], effect.split(":")[0])


def test_a_motor_that_stalls_is_looked_at_under_the_torques_that_it_bears() -> None:
    """By those of the measured motion it does next to nothing, and a torque limit would be named."""
    trials = explored("torque_speed:no_load_rad_s=4,stall_nm=1,joints=2")
    assert trials[0].hypothesis.names == ("torque_speed",)
    assert trials[0].hypothesis.terms[0].joints == (2,)


def test_a_joint_that_gives_way_and_hardly_rubs_is_not_lost_to_friction_before_the_fit() -> None:
    session = make_session(snake(), ["joint_friction:coulomb_nm=0.06,stiffness_nm_rad=60,joints=2"])
    evidence = gather(prepare(session))
    observed = usable_effects(evidence.data, over_ground=False).observed
    base = nominal_trial(evidence)

    def promised(effect: str) -> float:
        starts = [np.array(list(s.values())) for s in find_effect(effect).starts(observed, (1,))]
        return promise(evidence, base, added(base, Term(effect, (2,)), starts))

    assert promised("joint_friction") > LITTLE * promised("compliance") > 0


@pytest.mark.parametrize(
    ("effect", "kept"),
    [("compliance:stiffness_nm_rad=60,joints=2", "compliance"),
     ("joint_friction:coulomb_nm=0.3,stiffness_nm_rad=60,joints=2", "joint_friction")],
)  # fmt: skip
def test_dry_friction_of_nothing_is_a_joint_that_bends(effect: str, kept: str) -> None:
    """However it came about that the plainer effect was not held out itself."""
    evidence = gather(prepare(make_session(snake(), [effect])))
    library = usable_effects(evidence.data, over_ground=False)
    hypothesis = Hypothesis((Term("joint_friction", (2,)),))
    nominal = nominal_trial(evidence)
    rubs = run_trial(evidence, hypothesis, [np.array([0.1, 50.0])])
    found = by_plainer_effects(evidence, library, nominal, rubs)
    assert found.hypothesis.names == (kept,)
    assert found.theta[-1] == pytest.approx(60, rel=0.1)
    without = usable_effects(evidence.data, over_ground=False, exclude=["compliance"])
    assert by_plainer_effects(evidence, without, nominal, found).hypothesis.names == (kept,)
