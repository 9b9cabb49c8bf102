"""Gaits from rest, step by step, compiled: eight at once in the lanes of one processor register.

What is called here once for many gaits is ``run_blocks``; ``gaits`` makes its arguments and reads what it leaves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from snakebot.physics import rosenbrock
from snakebot.physics.compiled import jit
from snakebot.physics.elementary import sine_cosine
from snakebot.physics.kernel import FREE, TORQUE, WORK_ROWS
from snakebot.physics.lanes import WIDTH, get_lane, lane_rows, put_lane, sub_rows

# What the compiled loop leaves behind of a cycle: way, sums over steps, turn, sum of squared tracking errors.
MEASURES = ("dx", "dy", "heading", "power_in", "power_dissipated", "turn", "squared_error")

# Rows of the joints' scratch.
(PHI, DPHI, ACC, PHI_END, DPHI_END, ACC_END, PUSH, MEAN_TORQUE, GAP, STIFFNESS, DAMPING) = range(11)
JOINT_ROWS = 11  # as many as there are names above


@jit
def run_blocks(
    first: int, last: int, drives: Any, links: Any, slope: float, gains: Any, kind: Any, stuck: Any, share: Any,
    cycles: int, steps: int, out: Any, trace: Any,
) -> None:  # fmt: skip
    n = links.shape[1]
    for block in range(first, last):
        memory = np.zeros((SCRATCH_ROWS * max(n, 6) + 1) * WIDTH)
        results = np.zeros((out[0].size + 1) * WIDTH)
        history = np.zeros((trace.size + 1) * WIDTH)
        _block(
            block,
            memory,
            results,
            history,
            drives,
            links,
            slope,
            gains,
            kind,
            stuck,
            share,
            cycles,
            steps,
            out,
            trace,
        )


@jit
def _block(
    block: int, memory: Any, results_memory: Any, history: Any, drives: Any, links: Any, slope: float, gains: Any,
    kind: Any, stuck: Any, share: Any, cycles: int, steps: int, out: Any, trace: Any,
) -> None:  # fmt: skip
    """Eight gaits into lanes, and their results out of them. The last block repeats the last gait to be full."""
    count, averaged, measures = out.shape
    rows = lane_rows(memory, SCRATCH_ROWS, max(links.shape[1], 6))
    results = lane_rows(results_memory, averaged, measures)
    record = lane_rows(history, trace.shape[0], trace.shape[1])
    for lane in range(WIDTH):
        gait = min(block * WIDTH + lane, count - 1)
        for column in range(6):
            put_lane(rows, 0, column, lane, drives[gait, column])
    _eight_gaits(
        rows,
        links,
        slope,
        gains,
        kind,
        stuck,
        share,
        cycles,
        steps,
        averaged,
        results,
        record,
        trace.shape[0],
    )
    for lane in range(min(WIDTH, count - block * WIDTH)):
        for cycle in range(averaged):
            for measure in range(measures):
                out[block * WIDTH + lane, cycle, measure] = get_lane(results, cycle, measure, lane)
    if block == 0:
        for row in range(trace.shape[0]):
            for column in range(trace.shape[1]):
                trace[row, column] = get_lane(record, row, column, 0)


# Scratch of eight gaits: the gaits themselves, base, power, then joints, stage and work.
SCRATCH_ROWS = 3 + JOINT_ROWS + rosenbrock.STAGE_ROWS + WORK_ROWS


@jit
def _eight_gaits(
    rows: Any, links: Any, slope: float, gains: Any, kind: Any, stuck: Any, share: Any, cycles: int, steps: int,
    averaged: int, results: Any, record: Any, recorded: int,
) -> None:  # fmt: skip
    k = links.shape[1] - 1
    gait, base, power = rows[0], rows[1], rows[2]
    joints = sub_rows(rows, 3)
    stage = sub_rows(rows, 3 + JOINT_ROWS)
    work = sub_rows(rows, 3 + JOINT_ROWS + rosenbrock.STAGE_ROWS)
    eps = gait[5]
    h = (2 * math.pi / steps) / gait[2]
    for j in range(k):
        if kind[j] == TORQUE:
            joints[STIFFNESS, j] = gains[0]
            joints[DAMPING, j] = gains[2]
    _reference(gait, 0, steps, kind, stuck, share, joints[PHI], joints[DPHI], joints[ACC])
    if recorded > 0:
        _write(record[0], k, base, power, joints)
    for cycle in range(cycles):
        measured = cycle - (cycles - averaged)
        x, y, start = base[0], base[1], base[2]
        heading, power_in, lost, error = 0.0 * h, 0.0 * h, 0.0 * h, 0.0 * h
        for i in range(steps):
            now = cycle * steps + i + 1
            _reference(
                gait, now, steps, kind, stuck, share, joints[PHI_END], joints[DPHI_END], joints[ACC_END]
            )
            for j in range(k):
                joints[GAP, j] = joints[PHI_END, j] - h * joints[DPHI_END, j] - joints[PHI, j]
            rosenbrock.step(
                links, slope, eps, h, kind, base, joints[PHI], joints[DPHI], joints[ACC], joints[PHI_END],
                joints[DPHI_END], joints[ACC_END], joints[PUSH], joints[STIFFNESS], joints[DAMPING], work, stage,
                joints[MEAN_TORQUE], power,
            )  # fmt: skip
            for j in range(k):
                joints[ACC, j] = joints[ACC_END, j]
                if kind[j] == TORQUE:
                    gap = joints[PHI_END, j] - joints[PHI, j]
                    joints[PUSH, j] += gains[1] * 0.5 * h * (joints[GAP, j] + gap)
                    error += gap * gap
            if recorded > 0:
                _write(record[now], k, base, power, joints)
            heading += base[2]
            power_in += power[0]
            lost += power[1]
        if measured >= 0:
            results[measured, 0] = base[0] - x
            results[measured, 1] = base[1] - y
            results[measured, 2] = heading
            results[measured, 3] = power_in
            results[measured, 4] = lost
            results[measured, 5] = base[2] - start
            results[measured, 6] = error


@jit
def _reference(
    gait: Any, step: int, steps: int, kind: Any, stuck: Any, share: Any, phi: Any, dphi: Any, acc: Any
) -> None:
    """Angle, rate and acceleration at a step of joints that follow the gait or are stuck; free joints are left alone.

    Over the first cycle the amplitude grows by a ramp whose first two derivatives start and end at 0.
    """
    alpha, beta, omega, offset, late = gait[0], gait[1], gait[2], gait[3], gait[4]
    turn = 2 * math.pi / steps * (step % steps)
    ramp, d_ramp, dd_ramp = 1.0, 0.0, 0.0
    if step < steps:
        s = step / steps
        ramp = s * s * s * (10.0 + s * (6.0 * s - 15.0))
        d_ramp = 30.0 * (s * (1.0 - s)) ** 2 / (2 * math.pi)
        dd_ramp = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (2 * math.pi) ** 2
    for j in range(kind.size):
        if kind[j] == FREE:
            acc[j] = 0.0
        elif not math.isnan(stuck[j]):
            phi[j] = stuck[j]
            dphi[j] = 0.0
            acc[j] = 0.0
        else:
            sine, cosine = sine_cosine(turn + j * beta - late)
            f = share[j] * alpha * sine
            df = share[j] * alpha * cosine
            phi[j] = ramp * (f + offset)
            dphi[j] = omega * (d_ramp * (f + offset) + ramp * df)
            acc[j] = omega * omega * (dd_ramp * (f + offset) + 2.0 * d_ramp * df - ramp * f)


@jit
def _write(row: Any, k: int, base: Any, power: Any, joints: Any) -> None:
    for i in range(6):
        row[i] = base[i]
    row[6] = power[0]
    row[7] = power[1]
    for j in range(k):
        row[8 + j] = joints[PHI, j]
        row[8 + k + j] = joints[DPHI, j]
        row[8 + 2 * k + j] = joints[MEAN_TORQUE, j]
