"""Pictures of recordings that were answered wrongly: one joint's reading against its command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind.pictures import pyplot

SECONDS = 4.0  # from the start of a run: two swings of the slowest gaits


@dataclass(frozen=True)
class Trace:
    """Of a case: its folder, the 1-based joint to look at, and what was put in and said."""

    folder: Path
    joint: int
    title: str


def draw_traces(traces: Sequence[Trace], out: Path) -> list[Path]:
    """``wrong_1.png``, ... of the first run of each, in ``out``."""
    plt = pyplot()

    made = []
    for number, trace in enumerate(traces, 1):
        rows = np.genfromtxt(trace.folder / "run_01.csv", delimiter=",", names=True)
        early = rows["t_s"] < rows["t_s"][0] + SECONDS
        t = rows["t_s"][early]
        command, reading = (np.degrees(rows[f"{what}_{trace.joint}_rad"][early]) for what in ("cmd", "enc"))
        figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 4.5), constrained_layout=True)
        upper.plot(t, command, color="0.6", label="command")
        upper.plot(t, reading, color="C0", label="reading")
        upper.set_ylabel(f"joint {trace.joint}, deg")
        upper.legend(loc="upper right")
        upper.set_title(trace.title, fontsize=9)
        lower.plot(t, reading - command, color="C3")
        lower.set_ylabel("difference, deg")
        lower.set_xlabel("time, s")
        made.append(out / f"wrong_{number}.png")
        figure.savefig(made[-1], dpi=90)
        plt.close(figure)
    return made
