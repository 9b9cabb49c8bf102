"""A baseline that knows no model: a random forest on what a session looks like beside a plain lag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from blind.chain import Floats


def read_run(path: Path) -> tuple[Floats, Floats, Floats, Floats]:
    """t (T,), command (T, k), encoder (T, k), pose (T, 3)."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    k = (table.shape[1] - 4) // 2
    return table[:, 0], table[:, 1 : 1 + k], table[:, 1 + k : 1 + 2 * k], table[:, -3:]


def run_features(t_s: Floats, command: Floats, encoder: Floats, pose: Floats, lag_s: float) -> Floats:
    """Of the residual beside the nominal lag: offset, size, gain, delay, growth, turns, scatter; and the speed."""
    keep = np.exp(-np.diff(t_s)[0] / lag_s)
    should = np.zeros_like(command)
    for i in range(1, t_s.size):
        should[i] = command[i - 1] + (should[i - 1] - command[i - 1]) * keep
    off = encoder - should
    rate = np.gradient(should, t_s, axis=0)
    power, speed2 = (should**2).sum(axis=0) + 1e-9, (rate**2).sum(axis=0) + 1e-9
    half = t_s.size // 2
    left = off - off.mean(axis=0)
    per_joint = np.array(
        [
            off.mean(axis=0),
            off.std(axis=0),
            (left * should).sum(axis=0) / power,
            -(left * rate).sum(axis=0) / speed2,
            np.log((left[half:].std(axis=0) + 1e-6) / (left[:half].std(axis=0) + 1e-6)),
            (left * np.sign(rate)).mean(axis=0),
            np.diff(encoder, n=2, axis=0).std(axis=0),
            np.abs(np.diff(encoder, axis=0)).max(axis=0)
            / (np.abs(np.diff(should, axis=0)).max(axis=0) + 1e-9),
        ]
    )
    moved = pose[-1] - pose[half]
    turned = np.array([pose[half:, 2].mean()])
    spread = [per_joint.mean(axis=1), per_joint.min(axis=1), per_joint.max(axis=1), per_joint.std(axis=1)]
    return np.concatenate([*spread, moved, turned])


def session_features(folder: Path) -> Floats:
    """Mean and spread over the runs, and how far the repeat lies from the run it repeats."""
    runs = [read_run(path) for path in sorted(folder.glob("run_*.csv"))]
    told = yaml.safe_load((folder / "session.yaml").read_text(encoding="ascii"))
    lag_s = float(told["robot"]["servo"]["time_constant_s"])
    rows = np.array([run_features(*run, lag_s) for run in runs])
    apart = (runs[0][2] - runs[-1][2]).std(axis=0)
    return np.concatenate([rows.mean(axis=0), rows.std(axis=0), [apart.mean(), apart.max()]])
