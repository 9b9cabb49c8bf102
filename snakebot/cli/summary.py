"""What is printed at the end of a run: tracking error, loop, link, speed where known, joints' state, log, what next."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from snakebot.control import RecordedRun, RunResult
    from snakebot.control.progress import Progress

_MUCH_LONGER = 0.05  # standstills beyond this share of the motion's time are a warning
_JOINTS = {
    "disarmed": "relaxed, without power",
    "holding": "held, with power",
    "armed": "with power: the board's watchdog stops them",
    "stopped": "without power: emergency stop",
    "fault": "frozen by the board, and without power 2 s later",
}


def report(recorded: RecordedRun, *, as_json: bool) -> None:
    """Print the summary of a finished run, as text or as one JSON object; warnings go to standard error."""
    result, path = recorded.result, recorded.log_path
    summary = summarise(result, path, recorded.forward_speed_m_s, recorded.doubts)
    if as_json:
        click.echo(json.dumps(summary))
    else:
        _print(result, summary, path)
    tell_warnings(recorded)


def tell_warnings(recorded: RecordedRun) -> None:
    """What the user should know of the run, on standard error."""
    for warning in [*_warnings(recorded.result), *recorded.doubts]:
        click.echo(f"snakebot: warning: {warning}", err=True)


def _print(result: RunResult, summary: dict[str, Any], path: Path) -> None:
    from rich.table import Table

    from snakebot.cli.console import StandardOutput

    console = StandardOutput()
    console.print(
        f"run {result.ended} after {summary['duration_s']:.1f} s; tracking error (measured - set), "
        "TE as a share of the amplitude:"
    )
    table = Table()
    for name in ("joint", "rms deg", "TE"):
        table.add_column(name, justify="right")
    rows = zip(summary["rms_error_deg"], summary["tracking_error"], strict=True)
    for joint, (rms_deg, error) in enumerate(rows, start=1):
        table.add_row(
            str(joint),
            "-" if rms_deg is None else f"{rms_deg:.2f}",
            "-" if error is None else f"{error:.4f}",
        )
    console.print(table)
    trip = summary["round_trip_ms"]
    console.print(
        f"{summary['ticks']} ticks, {summary['late']} late, {summary['skipped']} skipped, "
        f"{summary['lost']} without an answer, {summary['clamped']} clamped by limits; round trip "
        + ("-" if trip is None else f"{trip:.2f} ms" if trip else "0: virtual time")
    )
    if result.progress.standstill.matters:
        console.print(f"{result.progress.standstill}; the simulated board stood still with it")
    if summary["forward_speed_m_s"] is not None:
        console.print(f"forward speed {summary['forward_speed_m_s']:.4f} m/s over the last cycles")
    if summary["steering"] is not None:
        console.print(_course_line(summary["steering"]))
    console.print(f"joints: {_JOINTS.get(summary['mode'], summary['mode'])}")
    console.print("log: ", end="")
    click.echo(str(path))
    log = shlex.quote(str(path))
    click.echo(f"next: snakebot analyze {log}    its figures; --report FILE.html a page")
    click.echo(f"      snakebot compare {log}    beside its simulation")
    if len(list(path.parent.glob("*.mcap"))) > 1:
        folder = shlex.quote(str(path.parent))
        click.echo(f"      snakebot diagnose {folder}    which effect makes robot and simulation differ")


def summarise(
    result: RunResult, path: Path, speed_m_s: float | None, doubts: Sequence[str] = ()
) -> dict[str, Any]:
    """The summary as plain values; what is not known is None."""
    progress = result.progress
    trip = progress.round_trip_s
    return {
        "ended": result.ended,
        "duration_s": round(result.duration_s, 6),
        "ticks": progress.ticks,
        "late": progress.late,
        "skipped": progress.skipped,
        "lost": progress.lost,
        "clamped": progress.clamped,
        "worst_lateness_ms": round(progress.worst_lateness_s * 1e3, 3),
        "standstills": progress.standstill.times,
        "stood_still_s": round(progress.standstill.total_s, 3),
        "round_trip_ms": None if math.isnan(trip) else round(trip * 1e3, 3),
        "mode": progress.mode.name.lower() if progress.mode is not None else None,
        "rms_error_deg": [
            None if math.isnan(rms) else round(math.degrees(rms), 4) for rms in progress.tracking.rms_rad
        ],
        "tracking_error": [None if math.isnan(e) else round(e, 6) for e in progress.tracking.error],
        "forward_speed_m_s": speed_m_s,
        "steering": _steering(progress),
        "log": str(path),
        "doubts": list(doubts),
    }


def _steering(progress: Progress) -> dict[str, Any] | None:
    """How the course was held; None where there was none."""
    steering = progress.steering
    if steering is None:
        return None
    error, aside = steering.error_rad, steering.cross_track_m
    return {
        "heading_error_deg": None if math.isnan(error) else round(math.degrees(error), 3),
        "cross_track_m": None if aside is None else round(aside, 5),
        "decisions": steering.decisions,
        "saturated": steering.saturated,
        "stale_times": steering.stale_times,
        "doubted_poses": steering.doubted,
        "bad_poses": progress.bad_poses,
    }


def _course_line(steering: dict[str, Any]) -> str:
    error, aside = steering["heading_error_deg"], steering["cross_track_m"]
    text = "course: heading error at the end " + ("-" if error is None else f"{error:.1f} deg")
    text += "" if aside is None else f", off the line {aside:.3f} m"
    text += f"; steering at its limit in {steering['saturated']} of {steering['decisions']} cycles"
    for count, what in (
        ("stale_times", "without a pose"),
        ("doubted_poses", "jumps"),
        ("bad_poses", "bad lines"),
    ):
        if steering[count]:
            text += f", {what}: {steering[count]}"
    return text


def _warnings(result: RunResult) -> list[str]:
    """What the user should know of this computer."""
    progress, warnings = result.progress, []
    if progress.often_late:
        warnings.append(progress.late_warning)
    longer_s = progress.standstill.total_s
    if longer_s > _MUCH_LONGER * result.duration_s and progress.standstill.matters:
        warnings.append(
            f"the run took {result.duration_s + longer_s:.1f} s for {result.duration_s:.1f} s of motion: this computer "
            "could not run the simulation all the time; if nobody stopped it, end other programs or add --fast"
        )
    return warnings
