"""A suite that passes everything proves nothing: boards with one fault each, and the case that must find it."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import boards
import pytest
from building import FIRMWARE, need
from mutation.child import start, wait_for_any

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
    ("say.c", "& SAMPLE_MASK", "& 0x7Fu", "wraps_sample_numbers"),
    ("say.c", ".board_time_us = board->modes.fault_since_us", ".board_time_us = hal_time_us()", "freezes_then_relaxes"),
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
    ("modes.c", "0u, 0};\n    modes->powered = false;\n}", "0u, 0};\n}", "stops_from_any_mode"),
    ("modes.c", "(modes->mode == HOLDING) && (host == modes->holder)", "modes->mode == HOLDING", "holding_needs_its_holder"),
    ("modes.c", "(modes->mode == HOLDING) && (host == modes->holder)", "host == modes->holder", "nothing_else_feeds_it"),
    ("modes.h", "SB_WATCHDOG_US 100000u", "SB_WATCHDOG_US 120000u", "faults_without_a_setpoint"),
    ("modes.h", "SB_RELAX_US 2000000u", "SB_RELAX_US 1500000u", "freezes_then_relaxes"),
    ("modes.h", "SB_HOLD_PATIENCE_US 1000000u", "SB_HOLD_PATIENCE_US 1100000u", "holding_needs_its_holder"),
    ("modes.c", "if (modes->mode != STOPPED) {\n        modes->fault_since_us = now_us;\n    }", "modes->fault_since_us = now_us;", "answers_every_stop"),
    ("limiter.c", "clamp(want, -stop, stop)", "want", "follows_the_limiter"),
    ("limiter.c", "clamp(braked, start.speed_rad_s - change, start.speed_rad_s + change)", "braked", "follows_the_limiter"),
    ("limiter.c", "(declared_us < available_us) ? declared_us : available_us", "declared_us", "bursts_gain_nothing"),
    ("limiter.c", "(dt_before_s + dt_s) / 2.0f", "dt_s + 2.0f * SB_ANGLE_STEP_RAD / dt_s", "follows_the_limiter"),
    ("limiter.c", "copysignf(stopping(fabsf(room), step), room)", "room / step->dt_s", "follows_the_limiter"),
    ("limiter.c", "clamp(target, near.angle_rad - SB_ANGLE_STEP_RAD, near.angle_rad + SB_ANGLE_STEP_RAD)", "target", "follows_the_limiter"),
    ("joints.c", "case RIGID:\n        return joints->hold_rad[joint] + trim_rad(joints, joint);", "", "rigid_goes_and_stays"),
    ("joints.c", "default:\n        return joints->limiter.applied_rad[joint];", "default:\n        return (float)setpoint * SB_ANGLE_STEP_RAD;", "rigid_here_stays"),
    ("joints.c", "read_one(joints, i); /* it starts where it is: nothing jumps */", "sb_limiter_follow(&joints->limiter, i, 0.5f);", "arms_where_the_joints_are"),
    ("joints.c", "(float)(setpoint + joints->trim[joint])", "(float)setpoint", "trims_the_servo"),
    ("joints.c", " - (float)joints->trim[joint];", ";", "trims_the_servo"),
    ("joints.c", "sb_limiter_follow(&joints->limiter, joint, angle_rad + trim_rad(joints, joint));", "sb_limiter_follow(&joints->limiter, joint, angle_rad + (float)joints->parameters.trim[joint] * SB_ANGLE_STEP_RAD);", "slews_to_a_new_trim"),
    ("requests.c", "(request->trim_rad > SB_MOST_TRIM) || ", "", "refuses_bad_values"),
    ("requests.c", "|| (request->trim_rad < -SB_MOST_TRIM)", "", "refuses_bad_values"),
    ("joints.h", "#define SB_MOST_TRIM 3000", "#define SB_MOST_TRIM 16580", "refuses_bad_values"),
    ("modes.c", "return (from == ARMED) || (from == HOLDING);", "return true;", "stays_stopped"),
    ("modes.c", "if (number != modes->latch) {", "if (number > modes->latch) {", "keeps_newer_stops"),
    ("modes.c", "{\n    next_latch(modes);\n    if (modes->mode != STOPPED) {", "{\n    if (modes->mode != STOPPED) {\n        next_latch(modes);", "numbers_its_latches"),
    ("modes.c", "modes->fault_since_us = now_us;\n    next_latch(modes);", "modes->fault_since_us = now_us;", "numbers_its_latches"),
    ("modes.c", "if (broken.code != SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE) {", "if (wanted == FAULT) {", "arms_no_faulty_hardware"),
    ("modes.c", "if ((modes->mode == STOPPED) || (modes->mode == FAULT)) {\n        disarm(modes);\n    }", "disarm(modes);", "clears_nothing_while_armed"),
    ("board.c", "sb_limiter_rest(&board->joints.limiter, now_us - board->executed_us);", "sb_limiter_reset(&board->joints.limiter);", "toggling_gains_nothing"),
    ("say.c", "request, answer.detail, host};", "request, answer.detail, board->modes.holder};", "answers_each_host"),
    ("say.c", "    sb_say_limits(board);\n}", "}", "reports_its_limits"),
    ("board.c", "(request.mode == ARMED) && (answer", "(board->modes.mode != before) && (answer", "reports_its_limits"),
    ("joints.c", "(uint32_t)(int32_t)joints->parameters.zero_counts[joint]", "0u", "shifts_the_zero"),
    ("requests.c", "        joints->parameters.zero_counts[joint] = request->zero_counts;\n", "        joints->parameters.zero_counts[joint] = request->zero_counts;\n        joints->parameters.trim[joint] = 0;\n", "trims_and_zeros_are_two_things"),
    ("requests.c", "        joints->parameters.trim[joint] = request->trim_rad;\n", "        joints->parameters.trim[joint] = request->trim_rad;\n        joints->parameters.zero_counts[joint] = 0;\n", "trims_and_zeros_are_two_things"),
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
    # Boards that keep or give power where they must not, know no limit but one joint's, or are kept alive by the wrong thing.
    ("board.c", "        sb_joints_power(&board->joints, false);\n        sb_say_fault(board);\n        return;", "        sb_say_fault(board);\n        return;", "stop_takes_all_power"),
    ("board.c", "        sb_joints_power(&board->joints, board->modes.powered);", "", "relaxed_joints_follow_their_encoders"),
    ("board.c", "        sb_joints_power(&board->joints, board->modes.powered);", "", "faults_freeze_with_power"),
    ("joints.c", "            joints->powered[i] = false;\n            hal_servo_off(i);", "            joints->powered[i] = false;\n            if (i != 2u) {\n                hal_servo_off(i);\n            }", "stop_takes_all_power"),
    ("joints.c", "powered && (joints->mode[i] != FREE)", "powered && ((joints->mode[i] != FREE) || joints->powered[i])", "freeing_takes_one_joints_power"),
    ("limiter.c", "limits = &limiter->limits[joint];", "limits = (joint == 0u) ? limiter->limits : &(struct sb_limits){9.0f, 99.0f, 999.0f};", "keeps_every_joints_limits"),
    ("limiter.c", "angle - ((want > 0.0f) ? start.angle_rad : -start.angle_rad)", "(want > 0.0f) ? angle - start.angle_rad : 9.0f", "keeps_every_joints_limits"),
    ("limiter.c", "clamp(wanted_rad, -limits->angle_rad, limits->angle_rad)", "fminf(wanted_rad, limits->angle_rad)", "keeps_every_joints_limits"),
    ("board.c", "/* incomplete so far */", "sb_modes_executed(&board->modes, now_us);", "only_setpoints_feed_armed"),
    ("board.c", "    if (board->modes.mode != ARMED) {\n        board->dropped++;", "    if (board->modes.mode != ARMED) {\n        sb_modes_executed(&board->modes, now_us);\n        board->dropped++;", "only_the_holder_feeds_holding"),
    ("requests.c", "sb_limit(&joints->limiter.limits[joint], request->kind)", "sb_limit(&joints->limiter.limits[0], request->kind)", "tightens_the_limits_of_each_joint"),
    ("joints.c", "if (joints->known[i]) {", "if (true) {", "unread_joints_get_no_power"),
    # Boards that compare times without their wrap: some are busy for ever, which is a failure, too.
    ("board.c", "return until(due_us, now_us) <= 0;", "return due_us <= now_us;", "keeps_time_across_the_wrap"),
    ("board.c", "return until(due_us, now_us) <= 0;", "return due_us <= now_us;", "limits_across_the_wrap"),
    ("board.c", "return (int32_t)(due_us - now_us);", "return (due_us > now_us) ? (int32_t)(due_us - now_us) : 0;", "keeps_time_across_the_wrap"),
]  # fmt: skip


def _sources(firmware: Path) -> list[Path]:
    folders = ("core", "core/generated", "port/model")
    return [
        *(path for folder in folders for path in (firmware / folder).glob("*.c")),
        firmware / "port/bench/bench.c",
    ]


def _compile(firmware: Path, sources: list[Path], out: Path) -> list[Path]:
    """Object files of these sources, in a folder."""
    need("cc")
    out.mkdir()
    command = ["cc", "-std=c11", "-O0", "-w", "-fPIC", "-c", f"-I{firmware}", f"-I{firmware / 'core'}"]
    subprocess.run([*command, f"-I{firmware / 'port'}", *map(str, sources)], check=True, cwd=out)
    return [out / f"{source.stem}.o" for source in sources]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Object files of the board without a fault."""
    return _compile(FIRMWARE, _sources(FIRMWARE), tmp_path_factory.mktemp("sound") / "objects")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "right", "wrong", "finder"), FAULTS, ids=[f"{f[3]}-{n}" for n, f in enumerate(FAULTS)]
)
def test_the_suite_finds_it(
    file: str, right: str, wrong: str, finder: str, tmp_path: Path, sound: list[Path]
) -> None:
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware)
    path = firmware / "core" / file
    text = path.read_text(encoding="utf-8")
    assert text.count(right) >= 1, f"{file} has changed: {right!r} is not there any more"
    path.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    changed = [path] if path.suffix == ".c" else _sources(firmware)  # a header may stand in each
    faulty = _compile(firmware, changed, tmp_path / "objects")
    replaced = {each.name for each in faulty}
    library = tmp_path / "faulty.so"
    others = [each for each in sound if each.name not in replaced]
    assert len(faulty) + len(others) == len(sound)
    subprocess.run(["cc", "-shared", "-o", str(library), *map(str, [*faulty, *others]), "-lm"], check=True)
    assert _found_by(library, finder), f"{finder} did not notice: {wrong!r} in place of {right!r}"


def _found_by(library: Path, finder: str) -> bool:
    """Whether a case fails on a faulty board, which may also crash, or find no end: it has a process of its own."""

    def ask() -> str:
        (case,) = (case for case in cases() if case.name == finder)
        with boards.core_in_process(ctypes.CDLL(str(library))) as bench:
            outcome = run_case(case, bench)
        assert outcome.verdict is not Verdict.FAILED or outcome.traffic
        return outcome.verdict.value

    child = start(ask)
    while (word := child.ended()) is None:
        wait_for_any([child])
    assert word != "crash (exit)"
    assert not word.startswith("error"), word
    return word not in (Verdict.PASSED.value, Verdict.SKIPPED.value)
