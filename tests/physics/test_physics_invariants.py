"""What holds for any chain, whatever its numbers; and two links against a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from snakebot.arrays import Floats
from snakebot.physics import (
    FREE,
    TORQUE,
    Chain,
    ChainModel,
    Drive,
    gait_eps_m_s,
    gait_trajectory,
    simulate_gaits,
)

FEW = settings(max_examples=15, derandomize=True, deadline=None, database=None)


def chain_model(
    n: int,
    seed: int = 0,
    friction: float = 1.0,
    coulomb: float = 0.0,
    contact: float = 0.0,
    slope_rad: float = 0.0,
) -> ChainModel:
    rng = np.random.default_rng(seed)
    mass, half = rng.uniform(0.5, 2.0, n), rng.uniform(0.05, 0.2, n)
    return ChainModel(
        mass=mass, half_length=half, inertia=mass * half**2 / 3,
        ct=friction * rng.uniform(0.1, 2, n), cn=friction * rng.uniform(5, 40, n),
        ct0=coulomb * rng.uniform(0.1, 0.6, n), cn0=coulomb * rng.uniform(0.5, 2, n),
        contact=np.full(n, contact), slope_rad=slope_rad,
    )  # fmt: skip


def momentum(chain: Chain) -> Floats:
    """Linear, and angular about the centre of mass."""
    m, J = chain.model.mass, chain.model.inertia
    v = chain.link_velocities_m_s()
    r = chain.link_positions_m() - chain.com_m
    rates = chain.heading_rate_rad_s + np.zeros(m.size)
    below = np.concatenate(([0.0], np.cumsum(chain.joint_rate_rad_s)))
    rates = rates + below - below.mean()
    spin = np.sum(m * (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0])) + np.sum(J * rates)
    return np.append(m @ v, spin)


def swing_freely(
    n: int, seed: int, dt: float, time: float, friction: float = 0.0, kick: bool = True
) -> tuple[Chain, Floats]:
    """A free chain that is set in motion by torques for 0.2 s, then left alone."""
    rng = np.random.default_rng(seed + 100)
    chain, drive = Chain(chain_model(n, seed, friction), dt), Drive.at_rest(n - 1)
    chain.reset(rng.uniform(-0.8, 0.8, n - 1), 0.1, -0.2, rng.uniform(-3, 3))
    drive.kind[:] = TORQUE
    drive.torque_nm[:] = rng.uniform(-0.3, 0.3, n - 1) * kick
    for _ in range(round(0.2 / dt)):
        chain.step(drive)
    drive.kind[:] = FREE
    states = []
    for _ in range(round(time / dt)):
        chain.step(drive)
        states.append((chain.energy_j(), *momentum(chain)))
    return chain, np.array(states)


@FEW
@given(st.integers(2, 12), st.integers(0, 50))
def test_without_friction_momentum_and_energy_are_kept(n: int, seed: int) -> None:
    chain, states = swing_freely(n, seed, 2e-4, 0.2)
    size = math.sqrt(2 * states[0, 0] * chain.model.mass.sum())
    assert np.abs(states[:, 1:3]).max() < 1e-11 * size  # internal torques move no centre of mass
    assert states[0, 0] > 1e-5
    assert states[:, 0] == pytest.approx(states[0, 0], rel=1e-3)
    assert np.abs(states[:, 3]).max() < 1e-4 * size * chain.model.half_length.sum()


def test_the_energy_error_falls_with_the_square_of_the_step() -> None:
    drift = []
    for dt in (4e-4, 2e-4, 1e-4):
        _, states = swing_freely(5, 3, dt, 0.4)
        drift.append(np.ptp(states[:, 0]) / states[0, 0])
    assert drift[1] < drift[0] / 3
    assert drift[2] < drift[1] / 3


@FEW
@given(st.integers(2, 10), st.integers(0, 50), st.floats(-3, 3), st.floats(-2, 2), st.booleans())
def test_a_turned_or_mirrored_start_turns_or_mirrors_the_motion(
    n: int, seed: int, turn: float, shift: float, mirror: bool
) -> None:
    rng = np.random.default_rng(seed)
    model = chain_model(n, seed, coulomb=1.0)
    angles = rng.uniform(-0.5, 0.5, n - 1)
    rates = rng.uniform(-1, 1, n - 1)
    kinds = rng.integers(0, 3, n - 1)
    sign = -1.0 if mirror else 1.0

    def run(sign: float, x: float, y: float, heading: float) -> Chain:
        chain, drive = Chain(model, 2e-3), Drive.at_rest(n - 1)
        chain.reset(sign * angles, x, y, heading)
        drive.kind[:] = kinds
        drive.torque_nm[:] = sign * 0.2
        for i in range(150):
            drive.angle_rad[:] = sign * (angles + rates * (i + 1) * 2e-3)
            drive.rate_rad_s[:] = sign * rates
            chain.step(drive)
        return chain

    plain = run(1.0, 0.0, 0.0, 0.0)
    other = run(sign, shift, -shift, turn)
    x, y = plain.com_m[0], sign * plain.com_m[1]
    moved = np.array([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y])
    assert other.com_m - (shift, -shift) == pytest.approx(moved, abs=1e-10)
    assert other.heading_rad - turn == pytest.approx(sign * plain.heading_rad, abs=1e-9)
    assert other.joint_torque_nm == pytest.approx(sign * plain.joint_torque_nm, abs=1e-7)
    assert other.power_dissipated_w == pytest.approx(plain.power_dissipated_w, rel=1e-7, abs=1e-12)


@FEW
@given(st.integers(2, 10), st.integers(0, 50), st.booleans(), st.floats(0.2, 1.0), st.floats(0.5, 2.0))
def test_at_steady_state_all_power_put_in_goes_to_the_ground(
    n: int, seed: int, coulomb: bool, alpha: float, omega: float
) -> None:
    model = chain_model(n, seed, coulomb=float(coulomb), contact=float(seed % 2))
    result = simulate_gaits(model, [alpha, 1.2, omega], cycles=12, steps_per_cycle=400)
    assert result.power_in_w == pytest.approx(result.power_dissipated_w, rel=0.01, abs=1e-6)


@FEW
@given(st.integers(2, 8), st.integers(0, 50))
def test_work_put_in_is_energy_gained_and_lost(n: int, seed: int) -> None:
    """Not only at steady state: over the first cycle from rest, on a slope."""
    model = chain_model(n, seed, coulomb=1.0, slope_rad=0.05)
    steps = 2000
    run = gait_trajectory(model, [0.6, 1.0, 2.0], cycles=1, steps_per_cycle=steps)
    h = run.t_s[1]
    end, drive = Chain(model.with_eps(gait_eps_m_s(model, 0.6, 2.0)), h), Drive.at_rest(n - 1)
    for i in range(1, steps + 1):
        drive.angle_rad[:], drive.rate_rad_s[:] = run.joint_angle_rad[i], run.joint_rate_rad_s[i]
        end.step(drive)
    balance = h * (run.power_in_w[1:].sum() - run.power_dissipated_w[1:].sum())
    assert balance == pytest.approx(end.energy_j(), abs=0.005 * h * run.power_dissipated_w.sum())


def two_links(m: float = 1.3, half: float = 0.11, c: float = 0.0) -> ChainModel:
    return ChainModel(
        mass=np.full(2, m), half_length=np.full(2, half), inertia=np.full(2, m * half**2 / 3),
        ct=np.full(2, c), cn=np.full(2, c), ct0=np.zeros(2), cn0=np.zeros(2), contact=np.ones(2),
    )  # fmt: skip


def test_two_free_links_fold_as_their_first_integral_says() -> None:
    """T = A psi'^2 + B phi'^2 / 2, A = J + m l^2 (1 + cos phi) / 2, B = (J + m l^2 (1 - cos phi) / 2) / 2."""
    model = two_links()
    m, half, J = model.mass[0], model.half_length[0], model.inertia[0]

    def inertia(phi: float) -> float:
        return float(0.5 * (J + 0.5 * m * half**2 * (1 - math.cos(phi))))

    dt = 1e-4
    chain, drive = Chain(model, dt), Drive.at_rest(1)
    chain.reset([0.3])
    drive.kind[:], drive.torque_nm[:] = TORQUE, 0.05
    for _ in range(1000):
        chain.step(drive)
    phi0, energy = chain.joint_angle_rad[0], chain.energy_j()
    assert energy == pytest.approx(0.05 * (phi0 - 0.3), rel=1e-5)  # the torque's work
    drive.kind[:] = FREE
    for _ in range(1000):
        chain.step(drive)
    # no spin: phi' = sqrt(2 E / B), so the time to get here is an integral
    time, _ = quad(lambda phi: math.sqrt(0.5 * inertia(phi) / energy), phi0, chain.joint_angle_rad[0])
    assert time == pytest.approx(0.1, rel=1e-5)
    assert chain.heading_rad == pytest.approx(0.0, abs=1e-12)


def test_torque_on_two_links_on_even_ground_in_closed_form() -> None:
    """With c_t = c_n = c friction is c/m times momentum: u = B phi'' + B' phi'^2 / 2 + (c/m) B phi'."""
    c = 3.0
    model = two_links(c=c)
    m, half, J = model.mass[0], model.half_length[0], model.inertia[0]
    alpha, omega = 0.7, 5.0
    run = gait_trajectory(model, [alpha, 0.3, omega], cycles=3, steps_per_cycle=4000)
    t = 0.5 * (run.t_s[8001:] + run.t_s[8000:-1])  # torques are means over steps
    phi, dphi, ddphi = (
        alpha * np.sin(omega * t),
        alpha * omega * np.cos(omega * t),
        -alpha * omega**2 * np.sin(omega * t),
    )
    B = 0.5 * (J + 0.5 * m * half**2 * (1 - np.cos(phi)))
    slope = 0.25 * m * half**2 * np.sin(phi)
    torque = B * ddphi + 0.5 * slope * dphi**2 + c / m * B * dphi
    assert run.joint_torque_nm[8001:, 0] == pytest.approx(torque, abs=1e-5 * np.abs(torque).max())
    assert np.abs(run.com_m).max() < 1e-12


def test_a_pushed_robot_on_even_ground_slows_down_exponentially() -> None:
    model = two_links(c=2.0)
    chain, drive = Chain(model, 1e-3), Drive.at_rest(1)
    chain._base[3:6] = (0.4, -0.1, 0.0)
    for _ in range(500):
        chain.step(drive)
    assert chain.com_velocity_m_s == pytest.approx(
        np.array([0.4, -0.1]) * math.exp(-2.0 / 1.3 * 0.5), rel=1e-5
    )


def test_a_straight_robot_rolls_down_a_slope_at_the_speed_where_friction_carries_it() -> None:
    """m g sin(slope) = c_t v + c_t0 on each link: how the paper's tangential friction was measured (31)."""
    slope = math.radians(3.0)
    model = ChainModel(
        mass=np.full(6, 1.43), half_length=np.full(6, 0.08), inertia=np.full(6, 0.003), ct=np.full(6, 0.83),
        cn=np.full(6, 51.9), ct0=np.full(6, 0.49), cn0=np.full(6, 2.33), contact=np.zeros(6), slope_rad=slope,
    )  # fmt: skip
    chain, drive = Chain(model, 0.01), Drive.at_rest(5)
    for _ in range(4000):
        chain.step(drive)
    speed = (1.43 * 9.80665 * math.sin(slope) - 0.49) / 0.83
    assert chain.com_velocity_m_s == pytest.approx([-speed, 0.0], abs=1e-6)
    assert chain.power_dissipated_w == pytest.approx(6 * (0.83 * speed + 0.49) * speed, rel=1e-6)


def test_a_robot_that_friction_can_hold_stays_where_it_is() -> None:
    model = ChainModel(
        mass=np.full(6, 1.43), half_length=np.full(6, 0.08), inertia=np.full(6, 0.003), ct=np.full(6, 0.83),
        cn=np.full(6, 51.9), ct0=np.full(6, 0.49), cn0=np.full(6, 2.33), contact=np.zeros(6),
        slope_rad=math.radians(1.0),
    )  # fmt: skip
    chain, drive = Chain(model, 0.01), Drive.at_rest(5)
    for _ in range(1000):
        chain.step(drive)
    assert (
        np.linalg.norm(chain.com_velocity_m_s) < model.eps
    )  # it creeps within the width of the regularised sign
