"""Confusion matrix, reliability diagram and power curves, as PNG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind.scores import Pair, confusion, power, probabilities, wilson

RELIABILITY_BINS = 5  # of a fifth each: fewer causes in a bin say nothing


@dataclass(frozen=True)
class Bin:
    """Of causes that were given about the same probability: their mean, the share that was right with its 95 %
    interval, and how many they are."""

    said: float
    right: float
    interval: tuple[float, float]
    causes: int


def reliability(p: np.ndarray, right: np.ndarray) -> list[Bin]:
    """Of (n,) probabilities and outcomes; bins without a cause are left out."""
    place = np.minimum((p * RELIABILITY_BINS).astype(int), RELIABILITY_BINS - 1)
    groups = [place == b for b in range(RELIABILITY_BINS) if (place == b).any()]
    return [
        Bin(
            float(p[g].mean()),
            float(right[g].mean()),
            wilson(int(right[g].sum()), int(g.sum())),
            int(g.sum()),
        )
        for g in groups
    ]


def pyplot() -> Any:
    """Matplotlib, drawing into files: no screen is needed."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def draw_reliability(p: np.ndarray, right: np.ndarray, folder: Path) -> Path:
    """``reliability.png``: what was said of causes, and the share that was right."""
    plt = pyplot()

    figure, axes = plt.subplots(figsize=(4.5, 4.5))
    axes.plot([0, 1], [0, 1], color="0.7")
    for one in reliability(p, right):
        axes.plot([one.said] * 2, one.interval, color="C0")
        axes.plot(one.said, one.right, "o", color="C0")
        axes.annotate(f" n = {one.causes}", (one.said, one.right))
    axes.set_xlabel("probability given to a cause")
    axes.set_ylabel("share that was right (bars: 95 %)")
    figure.savefig(folder / "reliability.png", dpi=110, bbox_inches="tight")
    plt.close(figure)
    return folder / "reliability.png"


def draw(pairs: Sequence[Pair], folder: Path) -> list[Path]:
    """The pictures of a set; of robots with many effects each there is nothing but the reliability to draw."""
    truths, said, table = confusion(pairs)
    if not truths:
        return [draw_reliability(*probabilities(pairs), folder)]
    plt = pyplot()

    made = []

    def save(name: str) -> None:
        path = folder / name
        plt.savefig(path, dpi=110, bbox_inches="tight")
        plt.close()
        made.append(path)

    plt.figure(figsize=(0.32 * len(said) + 3, 0.26 * len(truths) + 2))
    plt.imshow(
        table / np.maximum(table.sum(axis=1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1, aspect="auto"
    )
    for i, j in zip(*np.nonzero(table), strict=True):
        dark = table[i, j] > 0.5 * table[i].sum()
        plt.text(j, i, table[i, j], ha="center", va="center", color="white" if dark else "black", fontsize=8)
    plt.xticks(range(len(said)), said, rotation=90)
    plt.yticks(range(len(truths)), truths)
    plt.xlabel("first cause named, or verdict without one")
    plt.ylabel("truth")
    save("confusion.png")

    made.append(draw_reliability(*probabilities(pairs), folder))

    classes = ("low", "middle", "high")
    by_effect = power(pairs)
    overall = [[row[c] for row in by_effect.values() if c in row] for c in classes]
    _, (all_of_them, each) = plt.subplots(
        1, 2, figsize=(11, 0.24 * len(by_effect) + 2), width_ratios=(1, 1.2), constrained_layout=True
    )
    for i, cells in enumerate(overall):
        hits, cases = sum(h for h, _ in cells), sum(n for _, n in cells)
        if cases:
            low, high = wilson(hits, cases)
            all_of_them.plot([i, i], [low, high], color="C0")
            all_of_them.plot(i, hits / cases, "o", color="C0")
            all_of_them.annotate(f" n = {cases}", (i, hits / cases))
    all_of_them.set_xticks(range(3), [f"{c} size" for c in classes])
    all_of_them.set_ylim(-0.03, 1.03)
    all_of_them.set_ylabel("single effects named (bars: 95 %)")
    names = sorted(by_effect)
    shares = np.full((len(names), 3), np.nan)
    for i, name in enumerate(names):
        for j, c in enumerate(classes):
            if c in by_effect[name]:
                hits, cases = by_effect[name][c]
                shares[i, j] = hits / cases
                each.text(j, i, f"{hits}/{cases}", ha="center", va="center", fontsize=8)
    if names:
        each.imshow(shares, cmap="RdYlGn", vmin=0, vmax=1, aspect="auto", alpha=0.6)
    each.set_xticks(range(3), classes)
    each.set_yticks(range(len(names)), names)
    save("power.png")
    return made
