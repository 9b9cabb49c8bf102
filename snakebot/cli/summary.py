"""What is printed at the end of a run: tracking error, loop, link, speed where known, and the log's path."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from snakebot.control import RunResult

_SETTLE_SHARE = 0.5  # speed is averaged over the last half of the cycles at full amplitude, as the paper does


def report(result: RunResult, path: Path, *, as_json: bool) -> None:
    """Print the summary of a finished run, as text or as one JSON object."""
    summary = summarise(result, path)
    if as_json:
        click.echo(json.dumps(summary))
        return
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    table = Table(title=f"run {result.ended} after {summary['duration_s']:.1f} s")
    table.add_column("joint", justify="right")
    table.add_column("TE", justify="right")
    for joint, error in enumerate(summary["tracking_error"], start=1):
        table.add_row(str(joint), "-" if error is None else f"{error:.4f}")
    console.print(table)
    trip = summary["round_trip_ms"]
    console.print(
        f"{summary['ticks']} ticks, {summary['late']} late, {summary['skipped']} skipped, "
        f"{summary['lost']} without an answer, {summary['clamped']} clamped by limits; round trip "
        + ("-" if trip is None else f"{trip:.2f} ms")
    )
    if summary["forward_speed_m_s"] is not None:
        console.print(f"forward speed {summary['forward_speed_m_s']:.4f} m/s over the last cycles")
    console.print("log: ", end="")
    click.echo(str(path))


def summarise(result: RunResult, path: Path) -> dict[str, Any]:
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
        "round_trip_ms": None if math.isnan(trip) else round(trip * 1e3, 3),
        "tracking_error": [None if math.isnan(e) else round(e, 6) for e in progress.tracking.error],
        "forward_speed_m_s": _forward_speed(path),
        "log": str(path),
    }


def _forward_speed(path: Path) -> float | None:
    """Steady forward speed from the logged pose; None where there is none or the run was too short."""
    from snakebot.analysis.speed import forward_speed
    from snakebot.runlog import read_log

    run = read_log(path).to_run()
    if run.pose is None or run.gait is None or not math.isfinite(run.gait.period_s):
        return None
    ramp_s = float(run.metadata.get("ramp_s", 0.0))
    period = run.gait.period_s
    start, end = float(run.t_s[0]) + ramp_s, float(run.t_s[-1]) - ramp_s
    cycles = math.floor((end - start) / period * _SETTLE_SHARE + 1e-6)
    if cycles < 1:
        return None
    speed = forward_speed(run.t_s, run.pose, end - cycles * period, end, period)
    return None if speed is None else round(speed.forward_m_s, 6)
