"""A diagnosis in plain words, for a terminal or a page."""

from __future__ import annotations

from math import degrees

from snakebot.diagnosis.result import AngleClosure, Cause, Diagnosis, SpeedClosure

SURE, LIKELY = 0.85, 0.6


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    if diagnosis.verdict == "no_gap":
        return (
            "No gap: the robot does what the simulation says, within noise and the tolerance of its numbers."
        )
    if diagnosis.verdict == "unexplained":
        best = f" The nearest, {cause_name(diagnosis.causes[0])}, does not do." if diagnosis.causes else ""
        return f"Unexplained: there is a gap, and none of the known effects accounts for it.{best}"
    names = [cause_name(cause) for cause in diagnosis.causes]
    return f"Explained ({_sure(diagnosis)}): " + ", with ".join(names) + "."


def _sure(diagnosis: Diagnosis) -> str:
    least = min((cause.probability for cause in diagnosis.causes), default=0.0)
    return "sure" if least >= SURE else "likely" if least >= LIKELY else "a guess"


def cause_name(cause: Cause) -> str:
    """The effect, those it cannot be told from, and where it sits."""
    name = " or ".join((cause.effect, *cause.indistinguishable_from))
    if cause.stage == "body" or not cause.joints:
        return name
    which = "joint" if len(cause.joints) == 1 else "joints"
    return f"{name} on {which} {', '.join(map(str, cause.joints))}"


def cause_lines(cause: Cause) -> list[str]:
    """One line a parameter."""
    lines = []
    for name, value in cause.parameters.items():
        unit = f" {value.unit}" if value.unit else ""
        if value.ci95 is not None:
            spread = f"  (95 %: {value.ci95[0]:.4g} to {value.ci95[1]:.4g})"
        else:
            spread = "  (fixed)" if value.fixed else f"  ({value.reason})" if value.reason else ""
        lines.append(f"{name} = {value.estimate:.4g}{unit}{spread}")
    return lines


def summary(diagnosis: Diagnosis) -> list[str]:
    """The whole verdict, line by line."""
    lines = [headline(diagnosis)]
    for cause in diagnosis.causes:
        lines.append(f"  {cause_name(cause)}: probability {cause.probability:.0%}, stage {cause.stage}")
        lines += [f"    {line}" for line in cause_lines(cause)]
        lines.append(f"    --effect {cause.specification}")
    if diagnosis.verdict != "no_gap":
        shares = diagnosis.where.stage_shares
        parts = [f"{name} {share:.0%}" for name, share in shares.model_dump().items() if share >= 0.005]
        if parts:
            lines.append(f"Where: {', '.join(parts)}")
        if diagnosis.where.joints:
            lines.append(f"  joints {', '.join(map(str, diagnosis.where.joints))}")
        lines.append(f"  {diagnosis.where.regime}")
    lines += _closure(diagnosis)
    if diagnosis.unexplained.significant:
        lines.append(
            f"Left over: {diagnosis.unexplained.share:.1%} of the gap; {diagnosis.unexplained.where}"
        )
    if diagnosis.next_experiment is not None:
        lines.append(f"Next: {diagnosis.next_experiment.motion}: {diagnosis.next_experiment.reason}:")
        lines.append(f"  {diagnosis.next_experiment.command}")
    lines += [f"Warning: {warning}" for warning in diagnosis.warnings]
    return lines


def _closure(diagnosis: Diagnosis) -> list[str]:
    angle, speed = diagnosis.closure.joint_angle, diagnosis.closure.forward_speed
    lines = []
    if diagnosis.verdict == "no_gap":
        return [f"Joint angles: {degrees(angle.rms_before):.2g} deg rms off the prediction"]
    held_out = bool(diagnosis.closure.held_out_runs)
    where = "on held-out runs" if held_out else "on the runs that were fitted (none is held out)"
    if angle.closed is not None or not held_out:
        floor = "unknown" if angle.rms_floor is None else f"{degrees(angle.rms_floor):.2g} deg"
        lines.append(
            f"Joint angles {where}: {degrees(angle.rms_before):.3g} -> {degrees(angle.rms_after):.3g} deg rms, "
            f"floor {floor}{_closed(angle, 1)}"
        )
    if speed is not None and (speed.closed is not None or not held_out):
        lines.append(
            f"Forward speed {where}: off by {speed.error_before:.3g} -> {speed.error_after:.3g} m/s"
            f"{_closed(speed, 0)}"
        )
    return lines


def _closed(part: AngleClosure | SpeedClosure, digits: int) -> str:
    if part.closed is None:
        return ""
    ends = f" (95 %: {part.ci95[0]:.{digits}%} to {part.ci95[1]:.{digits}%})" if part.ci95 else ""
    return f": {part.closed:.{digits}%} closed{ends}"
