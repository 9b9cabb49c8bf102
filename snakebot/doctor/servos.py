"""What ``snakebot doctor`` looks at on a servo bus. Nothing moves, and nothing is written to a servo."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from snakebot.clock import RATE_HZ, Clock
from snakebot.doctor.finding import Finding, Status
from snakebot.errors import BadInputError, NoBoardError, SnakebotError
from snakebot.links.port import ServoPort
from snakebot.robot import JointServo, Robot
from snakebot.servobus.joints import SCAN_IDS, Joint, roll_call, wanted_servos
from snakebot.servobus.master import BusMaster
from snakebot.servobus.opening import open_master
from snakebot.servobus.scan import find_servos
from snakebot.servobus.settings import read_found
from snakebot.servobus.start import check_settings, measure_cycle, measure_latency
from snakebot.servobus.troubles import hardware_fault, words

_READS = 5  # of each servo and place: two of one id spoil each other's answers
_SENSORS = {"feetech": (56, 8), "dynamixel": (132, 15)}  # address, bytes: position, supply, temperature
_SLOW_DELAY_S = 50e-6  # before an answer, as set in a servo: above it a bus of many servos loses rate; chosen
_SLOW_ANSWER_S = 0.003  # chosen: as of a board
_NEAR_HOT_C = 10  # below the servo's own limit
_NEAR_LIMIT_V = 0.3  # above the servo's own lower limit; chosen


def check_servos(port: ServoPort, robot: Robot, clock: Clock) -> list[Finding]:
    """Everything that can be asked of servos without moving them.

    Raises:
        BadInputError: ids and description do not agree.
        NoBoardError: the port cannot be opened, or nobody answers on it.
    """
    wanted = wanted_servos(robot, port.ids)
    ids = sorted({*SCAN_IDS, *(each.id for each in wanted)})
    at, found = find_servos(port, clock, ids)
    if not found:
        raise NoBoardError(
            f"{port}: no servo answers at any usual bit rate: is the supply on, the cable whole, "
            f"and are these {port.family} servos?"
        )
    who = ", ".join(f"{each.id} ({each.name}, firmware {each.firmware_text})" for each in found)
    findings = [Finding("servos", Status.OK, who)]
    if at.baud != port.baud:
        advice = f"use {replace(port, baud=at.baud)}, or change it in the servos: 1000000 is best"
        findings.append(
            Finding("bit rate", Status.FAIL, f"they answer at {at.baud} baud, not {port.baud}", advice)
        )
    else:
        findings.append(_bit_rate(at.baud))
    master = open_master(at, clock)
    try:
        findings += _ids(master, wanted, [each.id for each in found])
        try:
            joints = roll_call(master, wanted)
        except (NoBoardError, BadInputError) as error:
            text = str(error).removeprefix(f"{master.where}: ")
            return [
                *findings,
                Finding("description", Status.FAIL, text, "give ids=..., or correct the description"),
            ]
        findings += _timing(master, joints)
        findings += _registers(master, robot, joints)
    finally:
        master.close()
    return findings


def _bit_rate(baud: int) -> Finding:
    if baud < 500_000:
        advice = "five servos need 1000000 for 100 cycles a second: change it in the servos"
        return Finding("bit rate", Status.WARN, f"{baud} baud", advice)
    return Finding("bit rate", Status.OK, f"{baud} baud")


def _ids(master: BusMaster, wanted: Sequence[JointServo], found: Sequence[int]) -> list[Finding]:
    """Each servo answers each question in its own words, and nobody else speaks."""
    findings = []
    missing = []
    # two of one make say the same of themselves, but hardly stand at the same place
    places = ((0, 8), _SENSORS[master.dialect.name])
    for servo in sorted({*found, *(each.id for each in wanted)}):
        answers, spoiled = 0, 0
        for place in places:
            before = master.statistics.corrupt + master.statistics.unasked
            answers += sum(master.read(servo, *place, tries=1) is not None for _ in range(_READS))
            spoiled = max(spoiled, master.statistics.corrupt + master.statistics.unasked - before)
        questions = len(places) * _READS
        if spoiled > _READS // 2:
            advice = "connect one of them alone and give it another id"
            findings.append(Finding("ids", Status.FAIL, f"two servos have the id {servo}", advice))
        elif not answers:
            missing.append(servo)
        elif answers < questions:
            advice = "noise or a loose plug: shorten the cable, check ground and supply"
            findings.append(
                Finding(
                    "ids", Status.WARN, f"servo {servo} answered {answers} of {questions} questions", advice
                )
            )
    if missing:
        names = ", ".join(map(str, missing))
        told = f"{names} do{'es' if len(missing) == 1 else ''} not answer"
        findings.append(Finding("ids", Status.FAIL, told, "cable, supply, bit rate, or another id?"))
    return findings or [Finding("ids", Status.OK, "each answers, nobody twice")]


def _timing(master: BusMaster, joints: Sequence[Joint]) -> list[Finding]:
    measure_latency(master, joints)
    cycle_s = measure_cycle(master, joints)
    findings = []
    answer_s = master.latency_s / 3
    if answer_s > _SLOW_ANSWER_S:
        advice = "the adapter holds bytes back: set its latency timer to 1 ms (docs/connect.md)"
        findings.append(Finding("answers", Status.WARN, f"within {1e3 * answer_s:.1f} ms (median)", advice))
    rate = 0.8 / cycle_s
    text = f"{1e3 * cycle_s:.2f} ms a cycle of {len(joints)} servos: up to {rate:.0f} Hz"
    if rate < RATE_HZ:
        findings.append(
            Finding("cycle", Status.WARN, text, f"run with --rate {rate:.0f} or less; see the other lines")
        )
    else:
        findings.append(Finding("cycle", Status.OK, text))
    return findings


def _registers(master: BusMaster, robot: Robot, joints: Sequence[Joint]) -> list[Finding]:
    findings = []
    for joint, limit_rad in zip(joints, robot.angle_limit_rad, strict=True):
        found = read_found(master, joint)
        if found is None:
            findings.append(Finding(joint.what, Status.FAIL, "stopped answering"))
            continue
        findings += _one(master, joint, found, limit_rad)
    return _gathered(findings)


def _gathered(findings: Sequence[Finding]) -> list[Finding]:
    """What is the same of several joints as one line."""
    same: dict[tuple[str, str, str], list[Finding]] = {}
    for each in findings:
        same.setdefault((each.status, each.found, each.advice), []).append(each)
    lines = []
    for group in same.values():
        names = [each.what.removeprefix("joint ") for each in group]
        what = f"joints {'+'.join(names)}" if len(group) > 1 else group[0].what
        lines.append(replace(group[0], what=what))
    return lines


def _one(master: BusMaster, joint: Joint, found: Mapping[str, int], limit_rad: float) -> list[Finding]:
    """One line about a servo that is well, and one for each thing that is not."""
    model, name = joint.model, f"joint {joint.number}"
    volts = model.si("present_voltage", found["present_voltage"])
    warm_c = found["present_temperature"]
    angle_deg = math.degrees(joint.angle_rad(found["present_position"]))
    text = f"servo {joint.id}: {angle_deg:.1f} deg, {volts:.1f} V, {warm_c} degC, torque " + (
        "on" if found["torque_enable"] else "off"
    )
    findings = []
    fault = hardware_fault(
        model, joint.number, found["hardware_error"], load_share=0.0, temperature_c=warm_c, voltage_v=volts
    )
    if fault is not None:
        advice = "mend that, then switch its supply off and on"
        findings.append(Finding(name, Status.FAIL, words(fault).removeprefix(f"{name}: "), advice))
    if warm_c > found["temperature_limit"] - _NEAR_HOT_C:
        findings.append(
            Finding(
                name, Status.WARN, f"{warm_c} degC: it stops at {found['temperature_limit']}", "let it cool"
            )
        )
    low, high = model.si("min_voltage", found["min_voltage"]), model.si("max_voltage", found["max_voltage"])
    if not low + _NEAR_LIMIT_V <= volts <= high:
        findings.append(
            Finding(
                name,
                Status.WARN,
                f"{volts:.1f} V: it wants {low:.1f} to {high:.1f}",
                "check supply and cable",
            )
        )
    delay_s = model.si("return_delay", found["return_delay"])
    if delay_s > _SLOW_DELAY_S:
        advice = "set return delay to 0 in the servo: each answer waits that long"
        findings.append(Finding(name, Status.WARN, f"return delay {1e6 * delay_s:.0f} us", advice))
    profile = [
        f"{key} {found[key]}" for key in ("profile_velocity", "profile_acceleration") if found.get(key)
    ]
    if profile:
        findings.append(
            Finding(name, Status.INFO, f"{', '.join(profile)}: set to none while it is armed, put back after")
        )
    try:
        check_settings(master, joint, found, limit_rad)
    except SnakebotError as error:
        text_ = str(error).removeprefix(f"{master.where}: {joint.what}").lstrip(": ")
        findings.append(Finding(name, Status.FAIL, text_))
    if abs(math.radians(angle_deg)) > limit_rad:
        advice = f"turn it back by hand: its limit is {math.degrees(limit_rad):.0f} deg"
        findings.append(Finding(name, Status.FAIL, f"stands at {angle_deg:.1f} deg", advice))
    least = model.watchdog_firmware
    if model.family == "dynamixel" and (least is None or joint.servo.firmware < least):
        advice = f"update its firmware to {least}, or run with --no-servo-watchdog"
        findings.append(
            Finding(name, Status.WARN, f"firmware {joint.servo.firmware} has no bus watchdog", advice)
        )
    bad = any(each.status in (Status.WARN, Status.FAIL) for each in findings)
    return [Finding(name, Status.INFO if bad else Status.OK, text), *findings]
