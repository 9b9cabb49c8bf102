"""Pictures: the joint at fault against its command in cases that were answered wrongly, and the reliability diagram."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from blind.scores import Pair, wilson

from blind_wheels.scores import probabilities

SECONDS = 4.0


def draw(
    cases: Path, wrong: Sequence[str], said: Mapping[str, Mapping[str, Any]], pairs: Sequence[Pair], out: Path
) -> list[Path]:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    made = []
    for number, token in enumerate(wrong, 1):
        about = said[token]
        joint = (about["joints"] or [1])[0]
        rows = np.genfromtxt(cases / token / "run_01.csv", delimiter=",", names=True)
        early = rows["t_s"] < SECONDS
        t = rows["t_s"][early]
        command, reading = (np.degrees(rows[f"{what}_{joint}_rad"][early]) for what in ("cmd", "enc"))
        figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 4.5), constrained_layout=True)
        upper.plot(t, command, color="0.6", label="command")
        upper.plot(t, reading, color="C0", label="reading")
        upper.set_ylabel(f"joint {joint}, deg")
        upper.legend(loc="upper right")
        upper.set_title(f"{about['fault']}, {about['size']:.1f} floors; said: {about['said']}", fontsize=9)
        lower.plot(t, reading - command, color="C3")
        lower.set_ylabel("difference, deg")
        lower.set_xlabel("time, s")
        made.append(out / f"wrong_{number}.png")
        figure.savefig(made[-1], dpi=90)
        plt.close(figure)
    p, right = probabilities(pairs)
    figure, axes = plt.subplots(figsize=(4.5, 4.5), constrained_layout=True)
    axes.plot([0, 1], [0, 1], color="0.7")
    for low in np.arange(5) / 5:
        here = (p >= low) & ((p < low + 0.2) | (low > 0.7))
        if here.any():
            bar = wilson(int(right[here].sum()), int(here.sum()))
            axes.plot([p[here].mean()] * 2, bar, color="C0")
            axes.plot(p[here].mean(), right[here].mean(), "o", color="C0")
            axes.annotate(f" n = {here.sum()}", (p[here].mean(), right[here].mean()))
    axes.set_xlabel("probability given to a cause")
    axes.set_ylabel("share that was right (bars: 95 %)")
    made.append(out / "reliability.png")
    figure.savefig(made[-1], dpi=90)
    plt.close(figure)
    return made
