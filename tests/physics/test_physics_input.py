"""What the physics refuses, and what it says then; options that change the drive."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from snakebot.errors import BadInputError
from snakebot.physics import (
    FREE,
    PRESCRIBED,
    Chain,
    ChainModel,
    Drive,
    Pid,
    gait_trajectory,
    replay,
    simulate_gaits,
)
from snakebot.robot import Body, load_robot

GAIT = [math.radians(66), math.radians(80), 2.0]


def body(**changes: object) -> Body:
    whole = load_robot("penn_state").body
    assert whole is not None
    return whole.model_copy(update=changes)


@pytest.fixture(scope="module")
def model() -> ChainModel:
    return ChainModel.from_body(body())


@pytest.mark.parametrize(
    ("gaits", "options", "words"),
    [
        ([[1.0, 1.0]], {}, "shape"),
        ([[1.0, 1.0, 0.0]], {}, "omega"),
        ([[1.0, math.nan, 1.0]], {}, "not finite"),
        ([GAIT], {"free_joints": [6]}, "no joint 6"),
        ([GAIT], {"rigid_joints": [0]}, "no joint 0"),
        ([GAIT], {"free_joints": [2], "rigid_joints": [2]}, "joint 2"),
        ([GAIT], {"rigid_joints": {2: math.inf}}, "stuck"),
        ([GAIT], {"cycles": 3}, "last 4 of 3"),
        ([GAIT], {"cycles": 0, "averaged_cycles": 0}, "cycles"),
        ([GAIT], {"steps_per_cycle": 3}, "too few"),
        ([GAIT], {"servo_time_constant_s": -1.0}, "time constant"),
        ([GAIT], {"threads": 0}, "0 threads"),
        (np.zeros((0, 3)), {}, "no gait"),
    ],
)
def test_gaits_that_make_no_sense(model: ChainModel, gaits: Any, options: dict[str, Any], words: str) -> None:
    with pytest.raises(BadInputError, match=words):
        simulate_gaits(model, gaits, **options)


@pytest.mark.parametrize(
    "change", [{"mass": np.zeros(6)}, {"ct": -1.0}, {"inertia": math.nan}, {"eps": 0.0}, {"ct": np.ones(5)}]
)
def test_models_that_make_no_sense(change: dict[str, Any]) -> None:
    numbers = dict.fromkeys(
        ("mass", "half_length", "inertia", "ct", "cn", "ct0", "cn0", "contact"), np.ones(6)
    )
    with pytest.raises(BadInputError, match=next(iter(change))):
        ChainModel(**(numbers | change))


@pytest.mark.parametrize("links", [1, 33])
def test_two_to_thirty_two_links(links: int) -> None:
    with pytest.raises(BadInputError, match="2 to 32"):
        one = np.ones(links)
        ChainModel(one, one, one, one, one, one, one, one)


@pytest.mark.parametrize("links", [2, 3, 16, 32])
def test_chains_of_any_length_move(links: int) -> None:
    chain = ChainModel.from_body(body(links=links))
    result = simulate_gaits(chain, [0.5, 2 * math.pi / max(links, 4), 2.0], cycles=5, averaged_cycles=1)
    assert result.power_in_w[0] == pytest.approx(result.power_dissipated_w[0], rel=0.02)
    if links > 2:  # two links only scull on the spot
        assert result.speed_m_s[0] > 0.005


def test_replays_that_make_no_sense(model: ChainModel) -> None:
    t = np.linspace(0, 1, 11)
    with pytest.raises(BadInputError, match=r"\(T, 5\)"):
        replay(model, t, np.zeros((11, 4)))
    with pytest.raises(BadInputError, match="rise"):
        replay(model, t[::-1], np.zeros((11, 5)))
    gap = np.zeros((11, 5))
    gap[3, 2] = np.nan
    with pytest.raises(BadInputError, match="joint 3 has no angle at sample 3"):
        replay(model, t, gap)
    with pytest.raises(BadInputError, match="no motion"):
        replay(model, t, np.zeros((11, 5))).speed_m_s(5.0)


def test_a_chain_that_makes_no_sense(model: ChainModel) -> None:
    with pytest.raises(BadInputError, match="time step"):
        Chain(model, 0.0)
    with pytest.raises(BadInputError, match="5 joints"):
        Chain(model, 1e-3).reset(np.zeros(4))


def test_payload_and_rubbing_wheel_change_what_they_should() -> None:
    plain = ChainModel.from_body(body())
    loaded = ChainModel.from_body(
        body(), added_mass_kg=[0, 0, 0.5, 0, 0, 0], extra_drag_n=[0, 0.3, 0, 0, 0, 0]
    )
    assert loaded.mass - plain.mass == pytest.approx([0, 0, 0.5, 0, 0, 0])
    assert loaded.ct0 - plain.ct0 == pytest.approx([0, 0.3, 0, 0, 0, 0])
    assert loaded.inertia == pytest.approx(plain.inertia)
    assert simulate_gaits(loaded, GAIT).speed_m_s[0] < simulate_gaits(plain, GAIT).speed_m_s[0]
    with pytest.raises(BadInputError, match="added_mass_kg"):
        ChainModel.from_body(body(), added_mass_kg=[1.0, 2.0])


def test_a_slope_slows_and_speeds(model: ChainModel) -> None:
    up = simulate_gaits(ChainModel.from_body(body(slope_deg=1.0)), GAIT).forward_speed_m_s[0]
    down = simulate_gaits(ChainModel.from_body(body(slope_deg=-1.0)), GAIT).forward_speed_m_s[0]
    assert up < simulate_gaits(model, GAIT).forward_speed_m_s[0] < down


def test_the_reversed_wave_goes_backwards(model: ChainModel) -> None:
    ahead, back = simulate_gaits(model, [GAIT, [GAIT[0], -GAIT[1], GAIT[2]]]).forward_speed_m_s
    assert back == pytest.approx(-ahead, rel=1e-6)


def test_an_offset_turns_the_robot(model: ChainModel) -> None:
    turn = simulate_gaits(model, [[*GAIT, 0.2], [*GAIT, -0.2]]).turn_rad
    assert abs(turn[0]) > 0.1
    assert turn[1] == pytest.approx(-turn[0], rel=0.02)


def test_a_servos_lag_is_less_amplitude_later(model: ChainModel) -> None:
    """A first-order lag answers alpha sin(omega t) by alpha cos(d) sin(omega t - d), tan d = omega tau."""
    tau = 0.2
    lagged = gait_trajectory(model, GAIT, servo_time_constant_s=tau, cycles=3)
    late = math.atan(GAIT[2] * tau)
    rows = lagged.t_s > 2 * math.pi / GAIT[2]
    expected = GAIT[0] * math.cos(late) * np.sin(
        GAIT[2] * lagged.t_s[rows, None] + np.arange(5) * GAIT[1] - late
    )  # fmt: skip
    assert lagged.joint_angle_rad[rows] == pytest.approx(expected, abs=1e-12)
    by_hand = simulate_gaits(model, [GAIT[0] * math.cos(late), *GAIT[1:]]).speed_m_s[0]
    assert simulate_gaits(model, GAIT, servo_time_constant_s=tau).speed_m_s[0] == pytest.approx(
        by_hand, rel=1e-3
    )


def test_stiff_torque_control_tracks_and_soft_control_does_not(model: ChainModel) -> None:
    ideal = simulate_gaits(model, GAIT)
    errors = []
    for gain in (300.0, 30.0, 3.0):
        got = simulate_gaits(model, GAIT, pid=Pid(gain, 0.0, 0.02 * gain))
        errors.append(got.tracking_error[0])
        if gain == 300.0:
            assert got.speed_m_s[0] == pytest.approx(ideal.speed_m_s[0], rel=5e-3)
            assert got.power_in_w[0] == pytest.approx(ideal.power_in_w[0], rel=5e-3)
    assert errors[0] < 1e-3 < 0.015 < errors[2]
    assert errors[0] < errors[1] < errors[2]
    with pytest.raises(BadInputError, match="kp_nm_rad"):
        Pid(-1.0)


def test_the_integral_term_takes_a_standing_error_away() -> None:
    """On a slope, bent to one side, a P servo sags; with an I term the mean error goes."""
    steep = ChainModel.from_body(body(slope_deg=1.9))
    gait = [1e-3, 1.0, 4.0, 0.3]
    sag = gait_trajectory(steep, gait, pid=Pid(3.0, 0.0, 0.5), cycles=40, steps_per_cycle=200)
    cured = gait_trajectory(steep, gait, pid=Pid(3.0, 3.0, 0.5), cycles=40, steps_per_cycle=200)
    mean_error = [np.abs(run.joint_angle_rad[-200:].mean(axis=0) - 0.3).max() for run in (sag, cured)]
    assert mean_error[1] < 0.2 * mean_error[0]


def test_a_joint_goes_free_and_is_caught_again_in_mid_run(model: ChainModel) -> None:
    chain, drive = Chain(model, 1e-3), Drive.at_rest(5)
    for i in range(1, 1500):
        drive.angle_rad[:] = 0.5 * np.sin(3e-3 * i + np.arange(5))
        drive.rate_rad_s[:] = 1.5 * np.cos(3e-3 * i + np.arange(5))
        if i == 500:
            drive.kind[2] = FREE
        if i == 1000:
            drive.kind[2] = PRESCRIBED
        if drive.kind[2] == PRESCRIBED and i >= 1000:  # held where it was caught
            drive.angle_rad[2], drive.rate_rad_s[2] = chain.joint_angle_rad[2], 0.0
        chain.step(drive)
        if 500 <= i < 1000:
            assert chain.joint_torque_nm[2] == 0.0
    assert np.all(np.isfinite(chain.joint_torque_nm))
    assert chain.joint_rate_rad_s[2] == 0.0
