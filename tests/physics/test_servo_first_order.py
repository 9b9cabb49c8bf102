"""First-order servos move in their own loop as in the one for all servos, which set-points that may be NaN take."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from snakebot.arrays import Floats
from snakebot.physics import servo_layout as layout
from snakebot.physics.servo_first_order import is_first_order
from snakebot.physics.servos_apart import run_apart

SAME_RAD = (
    1e-9  # the compiler may fuse products and sums otherwise; a dead band's edge does not make more of it
)


@st.composite
def servos(draw: st.DrawFn) -> Floats:
    """Rows of two first-order servos."""
    rows = layout.nominal_parameters(2, 0.0)
    for row in rows:
        row[layout.SIGN] = draw(st.sampled_from([1.0, -1.0]))
        row[layout.GAIN] = draw(st.floats(0.5, 1.5))
        row[layout.OFFSET_RAD] = draw(st.floats(-0.2, 0.2))
        row[layout.DEADBAND_RAD] = draw(st.sampled_from([0.0, 0.01, 0.1]))
        row[layout.DEADBAND_HARD] = draw(st.sampled_from([0.0, 1.0]))
        row[layout.TIME_CONSTANT_S] = draw(st.sampled_from([0.0, 0.004, 0.03, 0.3]))
        row[layout.RATE_LIMIT_RAD_S] = draw(st.sampled_from([0.5, 3.0, np.inf]))
        row[layout.BACKLASH_RAD] = draw(st.sampled_from([0.0, 0.02, 0.2]))
        row[layout.RATE_DROP_PER_S] = draw(st.sampled_from([0.0, 0.5]))
        row[layout.RATE_DROP_PER_NM] = draw(st.sampled_from([0.0, 0.3]))
        row[layout.COULOMB_NM] = draw(st.sampled_from([0.0, 0.2]))
        row[layout.LOOP_COMPLIANCE_RAD_NM] = draw(st.sampled_from([0.0, 0.1]))
        row[layout.COMPLIANCE_RAD_NM] = draw(st.sampled_from([0.0, 0.05]))
    rows[:, layout.SOURCE] = draw(st.permutations([0, 1]))
    return rows


def both_ways(
    rows: Floats,
    begin_rad: Floats,
    t_s: list[Floats],
    switch_s: list[Floats],
    setpoint_rad: list[Floats],
    **how: Any,
) -> tuple[list[Floats], list[Floats]]:
    """All angles, and all torques, as the loop for first-order servos has them; and as the one for all servos does."""
    assert all(is_first_order(row) for row in rows)

    def moved(switch_s: list[Floats], setpoint_rad: list[Floats]) -> list[Floats]:
        angle, felt = run_apart(rows, begin_rad, np.arange(2), t_s, switch_s, setpoint_rad, **how)
        return [np.concatenate(angle), np.concatenate(felt)]

    off = np.full((1, 2), np.nan)  # after the end of all runs: nothing comes of it, but that it is looked for
    late_off = [np.append(times, 1e3) for times in switch_s]
    return moved(switch_s, setpoint_rad), moved(
        late_off, [np.concatenate([told, off]) for told in setpoint_rad]
    )


@given(rows=servos(), seed=st.integers(0, 2**32 - 1), late_s=st.floats(0.0, 0.08))
def test_both_loops_move_a_first_order_servo_alike(rows: Floats, seed: int, late_s: float) -> None:
    rng = np.random.default_rng(seed)
    t_s = [np.cumsum(rng.uniform(1e-6, 0.03, size)) for size in (40, 1, 7)]
    switch_s = [np.cumsum(rng.uniform(1e-6, 0.03, size)) for size in (30, 3, 12)]
    setpoint_rad = [np.cumsum(rng.normal(0.0, 0.1, (times.size, 2)), axis=0) for times in switch_s]
    begin_rad, late = rng.normal(0.0, 0.3, (3, 2)), np.array([late_s, 0.0])
    coarse_s = 1.0  # both go from set-point to set-point and sample to sample
    own, general = both_ways(rows, begin_rad, t_s, switch_s, setpoint_rad, grid_s=coarse_s, late_s=late)
    for one, other in zip(own, general, strict=True):
        assert np.isfinite(one).all()
        np.testing.assert_allclose(one, other, atol=SAME_RAD, rtol=0.0)


@given(rows=servos(), seed=st.integers(0, 2**32 - 1), every_s=st.sampled_from([0.005, 0.02, 0.05]))
@settings(max_examples=30)
def test_under_load_it_is_where_ever_finer_steps_lead(rows: Floats, seed: int, every_s: float) -> None:
    rng = np.random.default_rng(seed)
    t_s = [np.arange(0.0, 3.0, every_s)]
    omega, lag = rng.uniform(1.0, 8.0), rng.uniform(0.0, 6.0, 2)
    setpoint_rad = [0.6 * np.sin(omega * t_s[0])[:, None] * [1.0, 0.5]]
    load_nm = [0.4 * np.sin(omega * t_s[0][:, None] + lag) + 0.1 * np.sin(3.1 * omega * t_s[0])[:, None]]
    (angle, felt), (exact, _) = both_ways(
        rows, np.zeros((1, 2)), t_s, [t_s[0] + 1e-3], setpoint_rad, grid_s=1e-4, load_nm=load_nm
    )
    np.testing.assert_allclose(
        felt[1:], load_nm[0][1:], atol=SAME_RAD
    )  # before the first step none was asked for
    swing = np.ptp(exact, axis=0).max()
    assert np.sqrt(np.mean(np.square(angle - exact))) < np.radians(0.1) + 0.002 * swing


def test_what_has_inertia_is_no_such_servo() -> None:
    (plain,) = layout.nominal_parameters(1, 0.03)
    assert is_first_order(plain)
    more = {
        layout.LOCKED: layout.RIGID_JOINT, layout.NATURAL_FREQ_RAD_S: 20.0, layout.LOOP_STIFFNESS_NM_RAD: 1.0,
        layout.ARM_GRAVITY_NM: 0.1, layout.ARM_INERTIA_KG_M2: 1e-3, layout.BACKLASH_LOADED: 1.0,
    }  # fmt: skip
    for column, value in more.items():
        row = plain.copy()
        row[column] = value
        assert not is_first_order(row), column
