"""The next experiment: safe, exact, cheap to say, and one that tells apart what the runs so far do not."""

from __future__ import annotations

import json
import shlex
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.cli.main import main
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.proposal import menu as of_menu
from snakebot.diagnosis.proposal.experiment import Proposal, motion_of, propose
from snakebot.diagnosis.proposal.menu import menu
from snakebot.diagnosis.proposal.motions import Motions, known_motions
from snakebot.effects.registry import find_effect
from snakebot.gait import check_motion, parse_probe
from snakebot.gait.probe import KINDS
from snakebot.robot import load_robot

FAST = ((66, 80, 2.0), (50, 80, 2.0))
ALL = (1, 2, 3, 4, 5)


def trial(evidence: Evidence, name: str, joints: tuple[int, ...]) -> Trial:
    term = Term(name, joints if find_effect(name).per_joint else None)
    return run_trial(evidence, Hypothesis((term,)), [np.array([p.typical for p in term.open])])


@cache
def proposed(truth: str, rivals: tuple[str, ...], joints: tuple[int, ...], pose: bool = False) -> Proposal:
    session = make_session(snake(), [truth], gaits=FAST, pose=pose)
    evidence = gather(prepare(session))
    return propose(evidence, [trial(evidence, name, joints) for name in rivals], 0.9)


def test_the_menu_is_safe_and_whole_and_moves_the_joints_in_question() -> None:
    robot, known = snake(), known_motions()
    one = menu(robot, [3], loads=True)
    assert len(one) == len(known.gaits) + len(known.probes) + len(known.lifted)
    for option in one:
        check_motion(option.motion, robot)
        if option.probe is not None:
            assert option.probe.joints == (3,)
    several = menu(robot, [2, 4], loads=False)
    assert {o.probe.joints for o in several if o.probe is not None} == {(2, 4), (4,)}
    assert not any(option.lifted for option in several)


def test_joints_that_move_alike_do_not_roll_the_robot_up() -> None:
    long = load_robot("saito_wheeled")
    for option in menu(long, range(1, long.joints + 1), loads=False):
        if option.probe is not None:
            assert np.degrees(np.abs(option.motion.sampled(np.arange(0, 12, 0.01))).sum(axis=1).max()) <= 201


def test_a_weak_robot_is_offered_nothing_beyond_its_limits() -> None:
    robot = snake()
    weak = robot.model_copy(
        update={"limits": robot.limits.model_copy(update={"speed_rad_s": 0.5, "angle_deg": 25.0})}
    )
    options = menu(weak, [1], loads=True)
    assert options
    t = np.arange(0, 12, 0.002)
    for option in options:
        angle = option.motion.sampled(t)
        assert np.degrees(np.abs(angle).max()) <= 25.01
        assert np.abs(np.diff(angle, axis=0)).max() / 0.002 <= 0.501


def test_a_delay_and_a_lag_are_told_apart_by_another_frequency_or_a_step() -> None:
    found = proposed("command_delay:delay_s=0.03", ("command_delay", "second_order"), ALL)
    nxt = found.experiment
    assert nxt is not None
    assert nxt.separates == (("command_delay", "second_order"),)
    if nxt.probe is not None:
        assert parse_probe(nxt.probe).kind in ("steps", "sine")
    else:
        assert nxt.gait is not None
        assert nxt.gait.omega_rad_s != 2
    assert 0.6 < nxt.expected_probability_after <= 0.9


@pytest.mark.parametrize(
    ("truth", "rivals", "joints"),
    [
        ("command_delay:delay_s=0.03", ("command_delay", "second_order"), ALL),
        pytest.param("deadband:width_deg=2,joints=3", ("deadband", "backlash"), (3,), marks=pytest.mark.slow),
        pytest.param(
            "rate_limit:limit_rad_s=2.6,joints=3", ("rate_limit", "voltage_sag"), (3,), marks=pytest.mark.slow
        ),
    ],
)
def test_the_command_is_the_motion_and_runs_as_it_stands(
    truth: str, rivals: tuple[str, ...], joints: tuple[int, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    nxt = proposed(truth, rivals, joints).experiment
    assert nxt is not None
    assert (nxt.gait is None) != (nxt.probe is None)
    words = shlex.split(nxt.command)
    assert words[:2] == ["snakebot", "run"]
    assert ("--lifted" in words) == nxt.lifted
    with pytest.raises(SystemExit) as ended:
        main([*words[1:], "--dry-run", "--json"])
    assert ended.value.code == 0
    shown = json.loads(capsys.readouterr().out)
    motion = motion_of(nxt, snake())
    assert shown["duration_s"] == pytest.approx(motion.duration_s)
    t = np.arange(0, motion.duration_s, 0.01)
    largest = np.degrees(np.abs(motion.sampled(t)).max(axis=0))
    assert [row["angle_deg"] for row in shown["joints"]] == pytest.approx(list(largest), abs=0.05)


def test_what_no_motion_tells_apart_is_left_to_another_channel() -> None:
    """The joint off by three degrees, or its encoder: without a pose the readings are the same whatever is done."""
    blind = proposed("servo_offset:offset_deg=3,joints=2", ("servo_offset", "encoder_offset"), (2,))
    assert blind.experiment is None
    assert blind.channel is not None
    assert "pose" in blind.channel


@pytest.mark.slow
def test_with_a_pose_the_joint_is_told_from_its_encoder_over_ground() -> None:
    seen = proposed("servo_offset:offset_deg=3,joints=2", ("servo_offset", "encoder_offset"), (2,), pose=True)
    assert seen.experiment is not None
    assert not seen.experiment.lifted


def test_a_pair_that_stays_open_beside_one_that_is_settled_gets_its_channel() -> None:
    found = proposed("command_gain:gain=0.9", ("command_gain", "encoder_gain", "servo_lag"), ALL)
    assert found.experiment is not None
    assert ("command_gain", "encoder_gain") not in found.experiment.separates
    assert found.channel is not None
    assert "servo_lag" not in found.channel


def test_what_parameters_can_make_up_for_separates_nothing() -> None:
    """A lag against itself with another start: every difference at the fits can be turned away."""
    session = make_session(snake(), ["servo_lag:time_constant_s=0.06"], gaits=FAST)
    evidence = gather(prepare(session))
    lag = trial(evidence, "servo_lag", ALL)
    sigma = np.sqrt(np.diag(lag.covariance))
    twin = Trial(
        **{**{f: getattr(lag, f) for f in lag.__dataclass_fields__}, "theta": lag.theta + 1.5 * sigma}
    )
    found = propose(evidence, [lag, twin], 0.9)
    assert found.experiment is None


def test_of_a_menu_that_holds_nothing_no_motion_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(of_menu, "known_motions", lambda: Motions((), (), (), ()))
    evidence = gather(prepare(make_session(snake(), ["command_delay:delay_s=0.03"], gaits=FAST)))
    found = propose(evidence, [trial(evidence, name, ALL) for name in ("command_delay", "second_order")], 0.9)
    assert found.experiment is None
    assert found.channel is not None
    assert "in every safe motion" not in found.channel


def test_one_explanation_needs_no_experiment() -> None:
    evidence = gather(prepare(make_session(snake(), gaits=FAST)))
    found = propose(evidence, [trial(evidence, "servo_lag", ALL)], 0.9)
    assert (found.experiment, found.channel) == (None, None)


@pytest.mark.slow
def test_a_motion_that_was_run_is_not_proposed_again() -> None:
    nxt = proposed("command_delay:delay_s=0.03", ("command_delay", "second_order"), ALL).experiment
    assert nxt is not None
    session = make_session(snake(), ["command_delay:delay_s=0.03"], gaits=FAST)
    run = session.runs[0]
    t = np.arange(1200) / 100
    again = type(run)("again", t, motion_of(nxt, snake()).sampled(t), motion_of(nxt, snake()).sampled(t))
    evidence = gather(prepare(type(session)(session.robot, (*session.runs, again))))
    rivals = [trial(evidence, name, ALL) for name in ("command_delay", "second_order")]
    other = propose(evidence, rivals, 0.9).experiment
    assert other is None or other.command != nxt.command


def test_a_richer_model_that_has_shrunk_to_the_simpler_one_is_said_to_be_it() -> None:
    """A second-order servo with much damping is a lag: there is nothing to run."""
    found = proposed("servo_lag:time_constant_s=0.06", ("servo_lag", "second_order"), ALL)
    assert found.experiment is None
    assert found.channel is not None
    assert "second_order, with the numbers found, moves like servo_lag" in found.channel


DOCUMENTED = [
    line
    for line in (Path(__file__).parents[3] / "docs" / "diagnosis.md").read_text(encoding="utf-8").splitlines()
    if line.startswith("snakebot run --probe")
]


@pytest.mark.parametrize("line", DOCUMENTED)
def test_a_probe_of_the_documentation_runs(line: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*shlex.split(line)[1:], "--dry-run"])
    assert ended.value.code == 0


def test_the_documentation_shows_every_kind_of_probe() -> None:
    assert {kind for kind in KINDS if any(f"--probe {kind}:" in line for line in DOCUMENTED)} == set(KINDS)
