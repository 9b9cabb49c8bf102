"""How a chain follows its servos, compiled: which joints are prescribed, which swing, and which the load can hold back.

A joint whose servo is stiff and strong is prescribed, one without torque swings, and one that the load holds back
(torque limit, torque-speed line, dry friction, a soft shaft or position loop, play) is driven by torque: a spring to
where its motor is, as far as the torque goes, less friction. A stiff joint with a limit is prescribed until it meets
the limit, and again when it has caught up. Spring and stiction are implicit; whether a joint slips is found by trying
the step again.

What a motor has is a line from stall to its no-load speed and beyond, where it brakes: stall (1 - rate / no load), the
same the other way round. A limit cuts the line off: the lesser of the two holds at each instant. A motor at its line is
a damper to the integrator, implicit like the ground. Taken as a limit on speed that falls with the torque just measured
it would oscillate from step to step: less speed, less torque, more speed.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.physics import rosenbrock
from snakebot.physics import servo_layout as layout
from snakebot.physics.compiled import in_place
from snakebot.physics.inertia import felt_inertia_kg_m2
from snakebot.physics.kernel import FREE, PRESCRIBED, TORQUE
from snakebot.physics.servo import is_free
from snakebot.physics.servo_layout import (
    DRIVEN,
    HELD_BACK,
    LOCKED,
    MOTOR,
    OUTPUT,
    OUTPUT_RATE,
    SMOOTH,
    SMOOTH_RATE,
)

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel


# Motors and gears of finite inertia do not jump in speed as a first-order lag with held set-points does. Left in, those
# jumps shake the wheels' dry friction loose and cost 4 % of the speed at 100 Hz, 10 % at 50 Hz.
SMOOTHING_S = 0.01  # critically damped, between servo and chain
STIFF_RAD_S = 60.0  # natural frequency of a stiff joint that has met its limit, beside what it knows to bear
CAUGHT_UP_RAD, CAUGHT_UP_RAD_S = 3e-4, 0.01  # within which it is stiff again
CONTACT_RAD_S = 200.0  # of one with play, where its gears touch: at 400 joints move the same to 0.05 deg
SOFT_DAMPING = 0.3  # damping ratio of a joint on a soft spring
STICK_RAD_S = 2e-3  # a joint slower than this sticks
ATTEMPTS = 8  # at a step, until no joint changes between sticking and slipping, spring and full torque

# Columns of a joint's grip, what the load can do to it.
STIFFNESS, DAMPING, COULOMB, LIMIT, STIFF, STALL, NO_LOAD, FADE, PLAY, BRAKE = range(10)
GRIP_COLUMNS = 10  # as many as there are names above
# Floats of the scratch.
OLD_BASE, OLD_PHI, OLD_DPHI, SLIDING, WEAK, PUSH, DRAG, KNOWN, SIDE, PULL, TURNED = range(11)
GRIP_SCRATCH_ROWS = 11  # as many as there are names above


def grips_of(params: Floats, model: ChainModel) -> Floats:
    """(joints, GRIP_COLUMNS): spring and damper between motor and joint, dry friction, torque limit, whether the spring
    stands for a stiff joint, the motor's line and how fast its no-load speed fades (1/s), half the play in which the
    joint swings, and a damper against the joint's own speed; no spring: prescribed.

    Of a position loop its armature and the friction that comes with load are left out: the links' inertia is what it
    moves.
    """
    give = params[:, layout.LOOP_COMPLIANCE_RAD_NM] + params[:, layout.COMPLIANCE_RAD_NM]
    stiff_loop = params[:, layout.LOOP_STIFFNESS_NM_RAD]
    looped = stiff_loop > 0
    give = give + np.where(looped, 1.0 / np.where(looped, stiff_loop, 1.0), 0.0)
    coulomb = params[:, layout.COULOMB_NM] + np.where(looped, params[:, layout.LOOP_COULOMB_NM], 0.0)
    limit = np.minimum(
        params[:, layout.TORQUE_LIMIT_NM], np.where(looped, params[:, layout.LOOP_LIMIT_NM], np.inf)
    )
    of_loop = params[:, layout.LOOP_DAMPING_NM_S] + params[:, layout.LOOP_VISCOUS_NM_S]
    slope = params[:, layout.RATE_DROP_PER_NM]
    line = slope > 0
    stall = np.where(line, 1.0 / np.where(line, slope, 1.0), np.inf)
    no_load = np.where(line, params[:, layout.RATE_LIMIT_RAD_S], np.inf)
    fade = np.where(line, params[:, layout.RATE_DROP_PER_S], 0.0)
    inertia = felt_inertia_kg_m2(model)
    soft = give > 0
    play = layout.half_swing_rad(params)
    stiff = inertia * np.where(play > 0, CONTACT_RAD_S, STIFF_RAD_S) ** 2
    stiffness = np.where(soft, 1.0 / np.where(soft, give, 1.0), stiff)
    damping = 2.0 * np.where(soft, SOFT_DAMPING, 1.0) * np.sqrt(stiffness * inertia)
    damping = np.where(looped, 0.0, damping)
    brake = np.where(looped, of_loop, 0.0)
    felt = soft | line | (coulomb > 0) | np.isfinite(limit) | (play > 0)
    columns = [
        np.where(felt, stiffness, 0.0),
        damping,
        coulomb,
        limit,
        ~soft & ~(play > 0),  # what it bore a moment ago was perhaps on the other side of the play
        stall,
        no_load,
        fade,
        play,
        brake,
    ]
    return np.stack(columns, axis=1)


@in_place
def follow(
    links: Any, slope: float, eps: float, grips: Any, kind: Any, base: Any, phi: Any, dphi: Any, torque: Any,
    power: Any, work: Any, stage: Any, scratch: Any, t: float, h: float, state: Any, params: Any, setpoint: Any,
    load: Any,
) -> None:  # fmt: skip
    """One step of the chain behind its servos, at ``t`` s since the run began."""
    k = phi.size
    fade = math.exp(-h / SMOOTHING_S)
    held = False
    for j in range(k):
        scratch[OLD_PHI, j] = phi[j]
        scratch[OLD_DPHI, j] = dphi[j]
        if is_free(params, setpoint, j):
            kind[j] = FREE
            continue
        springy = _springy(grips[j], params[j])
        was = kind[j]
        kind[j] = TORQUE if springy else PRESCRIBED
        aim = state[j, MOTOR] if springy else state[j, OUTPUT]
        y = state[j, SMOOTH] - aim
        z = state[j, SMOOTH_RATE] + y / SMOOTHING_S
        state[j, SMOOTH] = aim + fade * (y + z * h)
        state[j, SMOOTH_RATE] = fade * (state[j, SMOOTH_RATE] - z * h / SMOOTHING_S)
        twist = state[j, SMOOTH] - phi[j] - h * dphi[j]
        side = math.copysign(grips[j, PLAY], twist) if springy else 0.0
        scratch[SIDE, j] = side
        demand = grips[j, STIFFNESS] * (twist - side)
        slip = state[j, SMOOTH_RATE] - dphi[j]
        demand += grips[j, DAMPING] * slip + grips[j, STIFF] * load[j]
        pull = slip / h  # acceleration of a joint that keeps up
        if springy and was == PRESCRIBED and _keeps_up(grips[j]):
            demand = torque[j] + grips[j, STIFFNESS] / STIFF_RAD_S**2 * (pull - scratch[PULL, j])
        scratch[PULL, j] = pull
        if springy and _strong(grips[j], was, demand, twist, slip, dphi[j], t):
            kind[j] = PRESCRIBED
            continue
        held = held or springy
        if abs(twist) < grips[j, PLAY]:  # in the play
            scratch[WEAK, j], scratch[PUSH, j], scratch[DRAG, j] = 1.0, 0.0, 0.0
        else:
            scratch[WEAK, j], scratch[PUSH, j], scratch[DRAG, j] = _overdrawn(grips[j], demand, dphi[j], t)
        scratch[KNOWN, j] = grips[j, STIFF] * load[j]
        scratch[TURNED, j] = 0.0
        slides = grips[j, COULOMB] > 0.0 and abs(dphi[j]) > STICK_RAD_S
        scratch[SLIDING, j] = math.copysign(1.0, dphi[j]) if slides else 0.0
    for a in range(6):
        scratch[OLD_BASE, a] = base[a]
    for attempt in range(ATTEMPTS):
        if attempt > 0:
            for a in range(6):
                base[a] = scratch[OLD_BASE, a]
            for j in range(k):
                phi[j] = scratch[OLD_PHI, j]
                dphi[j] = scratch[OLD_DPHI, j]
        _try_step(
            links, slope, eps, grips, kind, base, phi, dphi, torque, power, work, stage, scratch, h, state
        )
        wrong = _overtaxed(grips, kind, torque, scratch, t)
        wrong = _overshoots(grips, kind, phi, dphi, scratch, state, t) or wrong
        if not (held and _slips(grips, kind, dphi, scratch)) and not wrong:
            break
        held = True
    for j in range(k):
        if kind[j] == FREE:
            state[j, OUTPUT] = phi[j]
            state[j, OUTPUT_RATE] = dphi[j]
        elif _springy(grips[j], params[j]):
            state[j, HELD_BACK] = phi[j] - state[j, SMOOTH]


@in_place
def _springy(grip: Any, row: Any) -> bool:
    """Whether there is a spring between this joint and its motor."""
    spring: bool = grip[STIFFNESS] > 0.0 and row[LOCKED] == DRIVEN
    return spring


@in_place
def _keeps_up(grip: Any) -> bool:
    """Whether nothing but a limit can hold this joint back."""
    nothing_else: bool = grip[STIFF] > 0.0 and grip[COULOMB] == 0.0
    return nothing_else


@in_place
def _strong(grip: Any, was: int, demand: float, twist: float, slip: float, rate: float, t: float) -> bool:
    """Whether a joint goes where its motor goes: one that did, until it takes more torque than there is; one that was
    held back, when it has caught up.
    """
    if not _keeps_up(grip):
        return False
    near = abs(twist) < CAUGHT_UP_RAD and abs(slip) < CAUGHT_UP_RAD_S
    return (was == PRESCRIBED or near) and _overdrawn(grip, demand, rate, t)[0] == 0.0


@in_place
def _overdrawn(grip: Any, demand: float, rate: float, t: float) -> tuple[float, float, float]:
    """Whether more torque is asked for than the motor has at this speed (the sign of it, or 0), and what it has then:
    torque at rest, less a drag for each rad/s.
    """
    limit, stall = grip[LIMIT], grip[STALL]
    no_load = grip[NO_LOAD] * math.exp(-grip[FADE] * t) if grip[FADE] > 0.0 else grip[NO_LOAD]
    for sign in (1.0, -1.0):
        line = stall * (1.0 - sign * rate / no_load)
        if sign * demand > min(max(line, -limit), limit):
            if abs(line) < limit:
                return sign, sign * stall, stall / no_load
            return sign, sign * math.copysign(limit, line), 0.0
    return 0.0, 0.0, 0.0


@in_place
def _try_step(
    links: Any, slope: float, eps: float, grips: Any, kind: Any, base: Any, phi: Any, dphi: Any, torque: Any,
    power: Any, work: Any, stage: Any, scratch: Any, h: float, state: Any,
) -> None:  # fmt: skip
    """One step with each joint sliding or sticking as ``scratch`` says."""
    acc, push, phi_end, dphi_end, stiffness, damping = (
        stage[7],
        stage[8],
        stage[9],
        stage[10],
        stage[11],
        stage[12],
    )
    for j in range(phi.size):
        acc[j] = push[j] = stiffness[j] = damping[j] = phi_end[j] = dphi_end[j] = 0.0
        if kind[j] == FREE:
            continue
        phi_end[j] = state[j, SMOOTH] - scratch[SIDE, j]
        dphi_end[j] = state[j, SMOOTH_RATE]
        if kind[j] == PRESCRIBED:
            acc[j] = (dphi_end[j] - dphi[j]) / h
            continue
        stick = grips[j, COULOMB] / STICK_RAD_S if scratch[SLIDING, j] == 0.0 else 0.0
        push[j] = -grips[j, COULOMB] * scratch[SLIDING, j]
        if scratch[WEAK, j] != 0.0:
            push[j] += scratch[PUSH, j]
            damping[j] = stick + grips[j, BRAKE] + scratch[DRAG, j]
            dphi_end[j] = 0.0
        else:
            push[j] += scratch[KNOWN, j]
            stiffness[j] = grips[j, STIFFNESS]
            damping[j] = grips[j, DAMPING] + grips[j, BRAKE] + stick
            # one damper works against the motor, the other and stiction against rest
            dphi_end[j] *= grips[j, DAMPING] / max(damping[j], 1e-12)
    rosenbrock.step(
        links, slope, eps, h, kind, base, phi, dphi, acc, phi_end, dphi_end, acc, push, stiffness, damping, work, stage,
        torque, power,
    )  # fmt: skip


@in_place
def _overtaxed(grips: Any, kind: Any, torque: Any, scratch: Any, t: float) -> bool:
    """Whether the step just tried took more of a motor than it has, or pulled at gears that can but push; ``scratch``
    is put right. Beside dry friction the motor's own part of the torque is not known: the next step sees to it.
    """
    wrong = False
    for j in range(torque.size):
        held = kind[j] == PRESCRIBED or (kind[j] == TORQUE and scratch[WEAK, j] == 0.0)
        if held and grips[j, PLAY] > 0.0 and torque[j] * scratch[SIDE, j] < 0.0:
            scratch[WEAK, j], scratch[PUSH, j], scratch[DRAG, j] = 1.0, 0.0, 0.0
            wrong = True
        if not held or grips[j, STIFFNESS] == 0.0 or grips[j, COULOMB] != 0.0:
            continue
        rate = scratch[OLD_DPHI, j]
        sign, push, drag = _overdrawn(grips[j], torque[j], rate, t)
        if sign != 0.0:
            kind[j] = TORQUE
            scratch[WEAK, j], scratch[PUSH, j], scratch[DRAG, j], scratch[SLIDING, j] = sign, push, drag, 0.0
            wrong = True
    return wrong


@in_place
def _overshoots(grips: Any, kind: Any, phi: Any, dphi: Any, scratch: Any, state: Any, t: float) -> bool:
    """Whether a motor that pulled with all it has, through the step just tried, carried its joint so far that it would
    pull as hard the other way at the end of it; ``scratch`` is put right: a spring, which is implicit, ends in between.

    Without this, light links under a torque limit shake from limit to limit, one step each way.
    """
    wrong = False
    for j in range(phi.size):
        if (
            kind[j] != TORQUE
            or scratch[WEAK, j] == 0.0
            or scratch[PUSH, j] == 0.0
            or scratch[TURNED, j] != 0.0
        ):
            continue
        demand = grips[j, STIFFNESS] * (state[j, SMOOTH] - phi[j] - scratch[SIDE, j])
        demand += grips[j, DAMPING] * (state[j, SMOOTH_RATE] - dphi[j]) + scratch[KNOWN, j]
        if _overdrawn(grips[j], demand, dphi[j], t)[0] == -scratch[WEAK, j]:
            scratch[WEAK, j], scratch[TURNED, j] = 0.0, 1.0
            wrong = True
    return wrong


@in_place
def _slips(grips: Any, kind: Any, dphi: Any, scratch: Any) -> bool:
    """Whether the step just tried was wrong about a joint that sticks or slides; ``scratch`` is put right."""
    wrong = False
    for j in range(dphi.size):
        if kind[j] != TORQUE or grips[j, COULOMB] == 0.0:
            continue
        was = scratch[SLIDING, j]
        if was == 0.0 and abs(dphi[j]) > STICK_RAD_S:
            scratch[SLIDING, j] = math.copysign(1.0, dphi[j])
            wrong = True
        elif was * dphi[j] < 0.0:
            scratch[SLIDING, j] = 0.0
            wrong = True
    return wrong
