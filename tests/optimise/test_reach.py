"""What a gait asks for beyond the recordings, and what is left of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from snakebot.cli.main import cli, main
from snakebot.effects import assemble, parse_effect
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.promise import OptimiseOptions, promises, row_of
from snakebot.optimise.reach import Reach, beyond, no_more
from snakebot.physics import servo_layout as layout
from snakebot.robot import Recorded, Robot, load_robot

ROBOT = load_robot("penn_state")
RECORDED = Recorded(
    omega_rad_s=2.0, joint_speed_rad_s=(1.5,) * 5, torque_nm=(0.4, 0.6, 0.7, 0.6, 0.4)
)  # of gaits up to (43, 80, 2)


def seen(recorded: Recorded = RECORDED, *effects: str) -> Robot:
    return ROBOT.model_copy(update={"recorded": recorded, "effects": effects})


def test_what_is_asked_beyond_is_told_with_both_numbers() -> None:
    row = row_of(Gait.from_degrees(40, 80, 4))
    found = {one.what: one for one in beyond(RECORDED, row, 0.65)}
    assert set(found) == {"an omega", "a joint speed"}
    assert found["a joint speed"].asked == pytest.approx(np.radians(40) * 4)
    assert str(found["an omega"]) == "an omega of 4 rad/s where 2 were recorded"
    assert not beyond(RECORDED, row_of(Gait.from_degrees(40, 80, 2.1)), 0.72)


def test_a_joint_that_never_moved_is_beyond_whatever_it_is_asked_for() -> None:
    still = Recorded(joint_speed_rad_s=(1.5, 0.0, 1.5, 1.5, 1.5))
    (one,) = beyond(still, row_of(Gait.from_degrees(5, 80, 0.5)), 0.1)
    assert one.recorded == 0.0


def test_the_servos_end_where_the_recordings_did_or_earlier() -> None:
    own = "torque_limit:limit_nm=0.5,joints=3"
    rows = assemble(seen(RECORDED, own), no_more(seen(RECORDED, own))).servo_rows
    np.testing.assert_allclose(rows[:, layout.TORQUE_LIMIT_NM], (0.4, 0.6, 0.5, 0.6, 0.4))
    np.testing.assert_allclose(rows[:, layout.RATE_LIMIT_RAD_S], 1.5)
    assert no_more(ROBOT) == ()


def test_a_gait_beyond_is_promised_with_what_is_left_and_one_within_without() -> None:
    gaits = [("fast", row_of(Gait.from_degrees(40, 80, 4))), ("slow", row_of(Gait.from_degrees(40, 80, 2)))]
    fast, slow = promises(seen(), gaits, OptimiseOptions(draws=0))
    plain = promises(ROBOT, gaits, OptimiseOptions(draws=0))
    assert [fast.speed_m_s, slow.speed_m_s] == [one.speed_m_s for one in plain]
    assert fast.speed_no_more_m_s is not None
    assert fast.speed_no_more_m_s < 0.9 * fast.speed_m_s
    assert slow.speed_no_more_m_s is None
    assert not slow.beyond
    assert not plain[0].beyond


def test_a_hidden_limit_leaves_no_less_than_was_told() -> None:
    """A torque limit just above what the recordings asked for: they say nothing of it, and the gait is a cliff."""
    row = row_of(Gait.from_degrees(31, 25, 5))
    weak = Recorded(omega_rad_s=5.0, joint_speed_rad_s=(3.0,) * 5, torque_nm=(0.8,) * 5)
    (told,) = promises(seen(weak), [("fast", row)], OptimiseOptions(draws=0))
    (true,) = promises(seen(weak, "torque_limit:limit_nm=0.9"), [("fast", row)], OptimiseOptions(draws=0))
    assert true.speed_m_s < 0.5 * told.speed_m_s
    assert [one.what for one in told.beyond] == ["a torque"]
    assert told.speed_no_more_m_s is not None
    assert told.speed_no_more_m_s <= true.speed_m_s


@pytest.mark.slow
@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_within_the_recordings_nothing_is_beyond(margin: float) -> None:
    within = {"alpha": (20.0, 60.0), "beta": (40.0, 110.0), "omega": (1.0, 5.0)}
    options = OptimiseOptions(within=within, draws=0, grid=(3, 3, 3), margin=margin, within_recorded=True)
    found = optimise(seen(RECORDED, "rate_limit:limit_rad_s=3"), Goal("speed"), options)
    for one in (found.found, *found.others):
        assert not one.beyond
        assert one.omega_rad_s <= 2.0
        assert np.radians(one.alpha_deg) * one.omega_rad_s <= 1.5 * (1 + 1e-9)
        assert one.torque_nm <= 0.7 * 1.01
    free = optimise(seen(RECORDED), Goal("speed"), replace(options, within_recorded=False))
    assert free.found.beyond
    assert free.found.speed_m_s > found.found.speed_m_s


def test_a_margin_is_of_what_a_servo_has_and_not_of_what_was_recorded() -> None:
    reach = Reach.of(seen(), None, 0.2)
    assert reach.torque_nm is not None
    assert max(reach.torque_nm) * 0.8 == pytest.approx(0.7)
    assert OptimiseOptions(within_recorded=True, torque_nm=0.5).torque(seen()) == pytest.approx(
        (0.4 / 0.9, 0.5, 0.5, 0.5, 0.4 / 0.9)
    )


def test_nothing_recorded_or_all_beyond_is_refused() -> None:
    with pytest.raises(BadInputError, match="does not say what was recorded: write its description by"):
        OptimiseOptions(within_recorded=True).space(ROBOT)
    with pytest.raises(
        BadInputError, match="omega from 3 rad/s on is beyond the fastest recorded gait, 2 rad/s"
    ):
        OptimiseOptions(within={"omega": (3.0, 4.0)}, within_recorded=True).space(seen())
    still = Recorded(joint_speed_rad_s=(0.0,) * 5)
    with pytest.raises(BadInputError, match="what was recorded allows joints 0 rad/s"):
        OptimiseOptions(within_recorded=True).space(seen(still))


def test_a_servo_of_another_kind_has_no_such_limits() -> None:
    spec = str(parse_effect("position_loop:stiffness_nm_rad=20,damping_nm_s_rad=1"))
    assert no_more(seen(RECORDED, spec)) == ()


def test_the_command_tells_it(tmp_path: Path) -> None:
    path = tmp_path / "seen.yaml"
    path.write_text(seen().to_yaml())
    words = [
        "optimize",
        str(path),
        "--for",
        "speed",
        "--draws",
        "2",
        "--grid",
        "2,2,2",
        "--out",
        str(tmp_path),
    ]
    words += ["--within", "alpha=39..40,beta=79..80,omega=3.9..4"]
    told = CliRunner().invoke(cli, words)
    assert told.exit_code == 0, told.output
    assert "Beyond the recordings: an omega of 4 rad/s where 2 were recorded" in told.output
    assert "If the servos can do no more than was recorded, it makes 0." in told.output
    found = json.loads(CliRunner().invoke(cli, [*words, "--json"]).output)["found"]
    assert found["speed_no_more_m_s"] < found["speed_m_s"]
    assert found["beyond"][0] == {"what": "an omega", "asked": 4.0, "recorded": 2.0, "unit": "rad/s"}


def test_live_runs_the_choice_itself(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(
            ["optimize", "penn_state", "--for", "speed", "--live", "sim:", "--logs", "n", "--within-recorded"]
        )
    assert ended.value.code == 2
    assert "--within-recorded: not with --live" in capsys.readouterr().err
