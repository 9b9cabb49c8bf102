"""A suite that passes everything proves nothing: boards with one fault each, and the case that must find it."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import boards
import pytest
from building import FIRMWARE, need

from snakebot.conformance import Verdict, cases, run_case

# ruff: noqa: E501
# file, what stands there, what a careless author writes, the case that must fail
FAULTS = [
    ("board.c", "board->dropped++;\n    } else if (sb_assembler_latch", "} else if (sb_assembler_latch", "drops_setpoints_unless_armed"),
    ("board.c", "sb_assembler_reset(&board->assembler);", "", "forgets_what_came_before_arming"),
    ("board.c", "board->first = true;", "", "holding_freezes"),
    ("board.c", "step >= HALF_RANGE", "step > HALF_RANGE + 64u", "knows_newer_from_older"),
    ("board.c", "sb_modes_executed(&board->modes, now_us);", "", "setpoints_feed_it"),
    ("board.c", "#define BEAT_US 100000u", "#define BEAT_US 130000u", "speaks_unasked"),
    ("board.c", "board->corrupt++;", "", "counts_bad_frames"),
    ("board.c", "& SAMPLE_MASK", "& 0x7Fu", "wraps_sample_numbers"),
    ("board.c", ".board_time_us = board->modes.fault_since_us", ".board_time_us = hal_time_us()", "freezes_then_relaxes"),
    ("board.c", "board->clamped = (uint16_t)(board->clamped + (clamped ? 1u : 0u));", "", "counts_clamped"),
    ("board.c", "(uint16_t)hal_random()", "7u", "starts_again_at_a_reset"),
    ("framing.c", "if (sb_crc16(body, length - 2u) != crc) {", "if (crc == 0x10000u) {", "counts_bad_packets"),
    ("framing.c", "decoder->corrupt++;", "", "counts_bad_packets"),
    ("setpoint.c", "!= one->latch.crc32", "== 1u", "refuses_torn_mixes"),
    ("setpoint.c", "one->latch.joints != assembler->joints", "false", "refuses_wrong_latches"),
    ("setpoint.c", "forget_older(assembler, one->key);", "", "forgets_remnants"),
    ("setpoint.c", "#define SHORT_MASK 0xFFFu", "#define SHORT_MASK 0x7FFu", "wraps_sequence_numbers"),
    ("setpoint.c", "if (group->group < SB_MAX_GROUPS) {", "if (true) { struct snakebot_setpoint_t *g = (struct snakebot_setpoint_t *)group; g->group %= 2u;", "ignores_groups_without_joints"),
    ("modes.c", "return (from == DISARMED) || (from == HOLDING);", "return true;", "keeps_the_table_of_modes"),
    ("modes.c", "modes->holder = host;", "modes->holder = 1u;", "is_held_by_one"),
    ("modes.c", "|| (host == SB_NOBODY)", "", "refuses_nobody"),
    ("modes.c", "modes->powered = false;\n}", "}", "stops_from_any_mode"),
    ("modes.c", "(modes->mode == HOLDING) && (host == modes->holder)", "modes->mode == HOLDING", "holding_needs_its_holder"),
    ("modes.c", "(modes->mode == HOLDING) && (host == modes->holder)", "host == modes->holder", "nothing_else_feeds_it"),
    ("modes.h", "SB_WATCHDOG_US 100000u", "SB_WATCHDOG_US 120000u", "faults_without_a_setpoint"),
    ("modes.h", "SB_RELAX_US 2000000u", "SB_RELAX_US 1500000u", "freezes_then_relaxes"),
    ("modes.h", "SB_HOLD_PATIENCE_US 1000000u", "SB_HOLD_PATIENCE_US 1100000u", "holding_needs_its_holder"),
    ("modes.c", "if (modes->mode != STOPPED) {\n        modes->fault_since_us = now_us;\n    }", "modes->fault_since_us = now_us;", "answers_every_stop"),
    ("limiter.c", "clamp(want, -stop, stop)", "want", "follows_the_limiter"),
    ("limiter.c", "clamp(braked, start.speed_rad_s - change, start.speed_rad_s + change)", "braked", "follows_the_limiter"),
    ("limiter.c", "(declared_us < credit) ? declared_us : credit", "declared_us", "bursts_gain_nothing"),
    ("limiter.c", "(dt_before_s + dt_s) / 2.0f", "dt_s + 2.0f * SB_ANGLE_STEP_RAD / dt_s", "follows_the_limiter"),
    ("limiter.c", "copysignf(stopping(fabsf(room), step), room)", "room / step->dt_s", "follows_the_limiter"),
    ("limiter.c", "clamp(target, near.angle_rad - SB_ANGLE_STEP_RAD, near.angle_rad + SB_ANGLE_STEP_RAD)", "target", "follows_the_limiter"),
    ("joints.c", "case RIGID:\n        return joints->hold_rad[joint];", "", "rigid_goes_and_stays"),
    ("joints.c", "default:\n        return joints->limiter.applied_rad[joint];", "default:\n        return setpoint_rad;", "rigid_here_stays"),
    ("joints.c", "read_one(joints, i); /* it starts where it is: nothing jumps */", "sb_limiter_follow(&joints->limiter, i, 0.5f);", "arms_where_the_joints_are"),
    ("joints.c", "joints->limiter.applied_rad[joint] + trim_rad", "joints->limiter.applied_rad[joint]", "trims_the_servo"),
    ("joints.c", "(uint32_t)(int32_t)joints->parameters.zero_counts[joint]", "0u", "shifts_the_zero"),
    ("joints.c", "(joints->mode[i] != FREE)", "(joints->mode[i] < 9u)", "free_follows_the_encoder"),
    ("requests.c", "if (sb_modes_held_against(modes, host)) {", "if (host == 0xFFFFFFFFu) {", "knows_its_joints"),
    ("requests.c", "(joint > joints->config->joints)", "(joint > 16u)", "knows_its_joints"),
    ("requests.c", "if (host == SB_NOBODY) {", "if (host == 0xFFFFFFFFu) {", "refuses_bad_values"),
    ("requests.c", "if (!disarmed(modes) && !sb_modes_held(modes)) {", "if (false) {", "forbids_by_mode"),
    ("requests.c", "(value > *in_force + half_step)", "(value < 0.0f)", "only_tightens_while_armed"),
    ("requests.c", "(request->value == 0u) || ", "", "refuses_limits_beyond_its_own"),
    ("requests.c", "(fabsf(angle_rad) > limit_rad)", "(fabsf(angle_rad) > 4.0f)", "refuses_bad_values"),
    ("generated/catalogue.h", "SB_CATALOGUE_HASH 0x", "SB_CATALOGUE_HASH 1u + 0x", "identifies_itself"),
    ("generated/catalogue.c", "if (value >= enumeration->named) {", "if (value >= 999u) {", "counts_bad_frames"),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "right", "wrong", "finder"), FAULTS, ids=[f"{f[3]}-{n}" for n, f in enumerate(FAULTS)]
)
def test_the_suite_finds_it(file: str, right: str, wrong: str, finder: str, tmp_path: Path) -> None:
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware)
    path = firmware / "core" / file
    text = path.read_text(encoding="utf-8")
    assert text.count(right) >= 1, f"{file} has changed: {right!r} is not there any more"
    path.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    sources = [
        *firmware.glob("core/*.c"),
        *firmware.glob("core/generated/*.c"),
        *firmware.glob("port/model/*.c"),
    ]
    library = tmp_path / "faulty.so"
    command = ["cc", "-std=c11", "-O0", "-w", "-fPIC", "-shared", f"-I{firmware}", f"-I{firmware / 'core'}"]
    command += [f"-I{firmware / 'port'}", "-o", str(library), *map(str, sources)]
    need("cc")
    subprocess.run([*command, str(firmware / "port/bench/bench.c"), "-lm"], check=True)
    (case,) = (case for case in cases() if case.name == finder)
    with boards.core_in_process(ctypes.CDLL(str(library))) as bench:
        outcome = run_case(case, bench)
    assert outcome.verdict is Verdict.FAILED, f"{finder} did not notice: {wrong!r} in place of {right!r}"
    assert outcome.traffic
