"""Confusion matrix, reliability diagram and power curves, as PNG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blind.scores import Pair, confusion, power, probabilities, wilson


def draw(pairs: Sequence[Pair], folder: Path) -> list[Path]:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    made = []

    def save(name: str) -> None:
        path = folder / name
        plt.savefig(path, dpi=110, bbox_inches="tight")
        plt.close()
        made.append(path)

    truths, said, table = confusion(pairs)
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

    p, right = probabilities(pairs)
    plt.figure(figsize=(4.5, 4.5))
    plt.plot([0, 1], [0, 1], color="0.7")
    for b in range(5):
        here = (p >= b / 5) & (p < (b + 1) / 5 if b < 4 else p <= 1)
        if here.any():
            low, high = wilson(int(right[here].sum()), int(here.sum()))
            plt.plot([p[here].mean()] * 2, [low, high], color="C0")
            plt.plot(p[here].mean(), right[here].mean(), "o", color="C0")
            plt.annotate(f" n = {here.sum()}", (p[here].mean(), right[here].mean()))
    plt.xlabel("probability given to a cause")
    plt.ylabel("share that was right (bars: 95 %)")
    save("reliability.png")

    plt.figure(figsize=(5.5, 4))
    classes = ("low", "middle", "high")
    overall = [[row[c] for row in power(pairs).values() if c in row] for c in classes]
    for i, cells in enumerate(overall):
        hits, cases = sum(h for h, _ in cells), sum(n for _, n in cells)
        if cases:
            low, high = wilson(hits, cases)
            plt.plot([i, i], [low, high], color="C0")
            plt.plot(i, hits / cases, "o", color="C0")
            plt.annotate(f" n = {cases}", (i, hits / cases))
    plt.xticks(range(3), [f"{c} size" for c in classes])
    plt.ylim(-0.03, 1.03)
    plt.ylabel("single effects named (bars: 95 %)")
    save("power.png")
    return made
