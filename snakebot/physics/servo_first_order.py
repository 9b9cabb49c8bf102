"""First-order servos under known loads: a whole run of one joint in a loop with nothing else in it.

Such a servo is a lag with gain, offset, dead band, rate limit, dry friction, compliance and play; most of what a
diagnosis tries is one. The laws are those of ``servo``; only what other servos would need besides is left out.

Each steps from set-point to set-point and sample to sample: in between its motor goes one way, in closed form.
Friction, sag and play follow where it is at the end of a step, under the torque of that moment; a limit that the torque
lowers is that of the middle of the step. Under a torque that changes meanwhile a step is short enough for that.
"""

from __future__ import annotations

import math
from typing import Any

from snakebot.physics.compiled import in_place
from snakebot.physics.servo import falling_limit, first_order, goal_of, play
from snakebot.physics.servo_chain import end_of_step
from snakebot.physics.servo_layout import (
    ARM_GRAVITY_NM,
    ARM_INERTIA_KG_M2,
    BACKLASH_LOADED,
    BACKLASH_RAD,
    COMPLIANCE_RAD_NM,
    COULOMB_NM,
    DEADBAND_HARD,
    DEADBAND_RAD,
    DRIVEN,
    GAIN,
    LOCKED,
    LOOP_COMPLIANCE_RAD_NM,
    LOOP_STIFFNESS_NM_RAD,
    NATURAL_FREQ_RAD_S,
    OFFSET_RAD,
    RATE_DROP_PER_NM,
    RATE_DROP_PER_S,
    RATE_LIMIT_RAD_S,
    SIGN,
    TIME_CONSTANT_S,
    TIME_GRAIN_S,
)

# Longest step under load. Measured: of sines of 1 to 8 rad/s, under torques of as many and three times as many, angles
# are off by 0.002 deg rms, by 0.03 deg in the worst of 60 servos; steps of 20 ms make it 0.006 and 0.06 deg.
LONGEST_STEP_S = 0.01


@in_place
def is_first_order(p: Any) -> bool:
    """Whether a servo (``servo_layout``'s row) is one of these."""
    return bool(
        p[LOCKED] == DRIVEN
        and p[NATURAL_FREQ_RAD_S] == 0.0
        and p[LOOP_STIFFNESS_NM_RAD] == 0.0
        and p[ARM_GRAVITY_NM] == 0.0
        and p[ARM_INERTIA_KG_M2] == 0.0
        and p[BACKLASH_LOADED] == 0.0
    )


@in_place
def run_first_order(
    p: Any, angle: float, held: float, late: float, t: Any, load_t: Any, switch_t: Any, switch_u: Any,
    out: Any, out_load: Any,
) -> None:  # fmt: skip
    """Joint angles ``out`` (T,) of a servo that ``is_first_order``, from rest at ``angle``, and what it bore.

    Args:
        held: set-point that keeps it there.
        late: how much later than ``switch_t`` its set-points come into force, s.
        t: (T,) times, not falling.
        load_t: (T,) torques on the servo at those times, or none.
        switch_t: (M,) rising, when each set-point comes into force.
        switch_u: (M,) set-points, none of them NaN.
    """
    gain, offset = p[GAIN] * p[SIGN], p[OFFSET_RAD]
    band, hard, slack = p[DEADBAND_RAD], p[DEADBAND_HARD] > 0.0, 0.5 * p[BACKLASH_RAD]
    tau, rate_limit = p[TIME_CONSTANT_S], p[RATE_LIMIT_RAD_S]
    per_s, per_nm = p[RATE_DROP_PER_S], p[RATE_DROP_PER_NM]
    give, compliance, friction = p[LOOP_COMPLIANCE_RAD_NM], p[COMPLIANCE_RAD_NM], p[COULOMB_NM]
    falls = per_s != 0.0 or per_nm != 0.0
    loaded, middle, load, at = load_t.size > 0, 0.0, 0.0, 0
    asleep, dragged, motor, target = True, angle, angle, gain * held + offset
    now, start = t[0] - late, t[0] - late
    coming, steps = 0, 0.0
    for row in range(t.size):
        sample = t[row] - late
        while True:
            while coming < switch_t.size and switch_t[coming] <= now + TIME_GRAIN_S:
                target = gain * switch_u[coming] + offset
                coming += 1
            if sample <= now + TIME_GRAIN_S:
                break
            mark = start + (steps + 1.0) * LONGEST_STEP_S if loaded else math.inf
            until, tick = end_of_step(sample, switch_t, coming, mark)
            dt = until - now
            if loaded:
                if falls:
                    middle, at = _between(t, load_t, 0.5 * (now + until) + late, at)
                load, at = _between(t, load_t, until + late, at)
            if asleep:  # it is switched on where its joint is, bearing what hangs on it
                dragged = angle + load * compliance
                motor = dragged + load * give
                asleep = False
            limit = rate_limit
            if falls:
                goal, _ = goal_of(motor, target, band, hard)
                limit = falling_limit(
                    limit, per_s, per_nm, middle if goal > motor else -middle, now - start + 0.5 * dt
                )
            motor = first_order(motor, target, band, hard, tau, limit, dt)
            dragged = play(dragged, motor - load * give, friction * give)
            angle = play(angle, dragged - load * compliance, slack)
            now = until
            if tick:
                steps += 1.0
        out[row], out_load[row] = angle, load


@in_place
def _between(t: Any, values: Any, now: float, at: int) -> tuple[float, int]:
    """``values`` (T,) at the time ``now``, looked for from row ``at``; and the row to go on from."""
    while at < t.size - 2 and t[at + 1] < now:
        at += 1
    last = min(at + 1, t.size - 1)
    share = min(max((now - t[at]) / (t[last] - t[at]), 0.0), 1.0) if t[last] > t[at] else 0.0
    return values[at] + share * (values[last] - values[at]), at
