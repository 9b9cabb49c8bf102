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
