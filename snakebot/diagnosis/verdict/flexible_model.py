"""A flexible model that names nothing: how much of a residual can be predicted at all from what was commanded.

A bank of operators (delays, rate limiters, play of several widths, powers, load, time, neighbours) is run on
the nominal motion, and a ridge regression on their outputs predicts the residual, fitted and scored on the same
folds as the effects. If it predicts on held-out gaits what the best effects leave over, there is something that
no known effect says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.folds import Fold
from snakebot.diagnosis.evidence.operators import limited, play

DELAYS_S = (0.03, 0.08, 0.15, 0.3)  # delays in the bank of operators, s; chosen
PLAY_RAD = (0.01, 0.03, 0.1, 0.3)  # half widths of plays, rad; chosen
RATE_SHARES = (0.3, 0.6, 0.85)  # rate limits, over the largest nominal rate; chosen
RIDGES = (1e-4, 1e-2, 1.0)  # ridge penalties that are tried, over the mean square of a feature; chosen


def residual_prediction(
    data: Data,
    nominal_rad: Sequence[Floats],
    residual: Sequence[Floats],
    load_nm: Sequence[Floats] | None,
    folds: Sequence[Fold],
) -> list[Floats]:
    """Held-out prediction of the residual, (N, k) a run; zero for runs that are in no fold's scored part.

    Runs held out by the user are predicted from all others.
    """
    out = [np.zeros(r.shape) for r in residual]
    held = tuple(i for i, run in enumerate(data.runs) if run.hold_out)
    free = tuple(i for i, run in enumerate(data.runs) if not run.hold_out)
    parts = [(fold.fit, fold.score) for fold in folds]
    if held and free:
        parts.append((free, held))
    if not parts:
        return out
    for joint in range(data.joints):
        features = [_features(data, nominal_rad, load_nm, i, joint) for i in range(len(data.runs))]
        use = [run.use[:, joint] for run in data.runs]
        grams = [
            _gram(f[u], residual[i][u, joint]) for i, (f, u) in enumerate(zip(features, use, strict=True))
        ]
        ridge = _choose(grams, folds)
        for fit, scored in parts:
            weight = _solve(grams, fit, ridge)
            if weight is not None:
                for i in scored:
                    out[i][:, joint] = features[i] @ weight
    return out


def _gram(x: Floats, y: Floats) -> tuple[Floats, Floats, float, int]:
    return x.T @ x, x.T @ y, float(y @ y), y.size


def _choose(grams: Sequence[tuple[Floats, Floats, float, int]], folds: Sequence[Fold]) -> float:
    best, chosen = np.inf, RIDGES[-1]
    for ridge in RIDGES:
        error = 0.0
        for fold in folds:
            weight = _solve(grams, fold.fit, ridge)
            if weight is None:
                continue
            for i in fold.score:
                xx, xy, yy, _ = grams[i]
                error += yy - 2 * float(weight @ xy) + float(weight @ xx @ weight)
        if error < best:
            best, chosen = error, ridge
    return chosen


def _solve(
    grams: Sequence[tuple[Floats, Floats, float, int]], runs: Sequence[int], ridge: float
) -> Floats | None:
    count = sum(grams[i][3] for i in runs)
    if count < 10:
        return None
    xx = sum((grams[i][0] for i in runs), np.zeros_like(grams[0][0]))
    xy = sum((grams[i][1] for i in runs), np.zeros_like(grams[0][1]))
    scale = np.sqrt(np.diag(xx) / count)
    scale[scale < 1e-9] = np.inf  # a feature that is always zero gets no weight
    a = xx / np.outer(scale, scale) / count
    return np.asarray(np.linalg.solve(a + ridge * np.eye(a.shape[0]), xy / scale / count) / scale)


def _features(
    data: Data, nominal_rad: Sequence[Floats], load_nm: Sequence[Floats] | None, index: int, joint: int
) -> Floats:
    run = data.runs[index]
    t = run.t_s
    q = np.nan_to_num(nominal_rad[index][:, joint])
    rate = np.gradient(q, t)
    fastest = max(float(np.quantile(np.abs(rate), 0.98)), 1e-6)
    unit = fastest / 3
    columns = [np.ones_like(t), q, rate, np.tanh(rate / unit), np.tanh(4 * rate / unit), rate * np.abs(rate)]
    columns += [np.interp(t - d, t, q) - q for d in DELAYS_S]
    columns += [np.interp(t - d, t, rate) for d in DELAYS_S[1:]]
    columns += [limited(t, q, share * fastest) - q for share in RATE_SHARES]
    columns += [play(q, width) - q for width in PLAY_RAD]
    columns += [np.sin(q), np.cos(q), q * np.abs(q), t * q / t[-1], t * rate / t[-1]]
    columns += [np.abs(q), np.gradient(rate, t)]
    for other in (joint - 1, joint + 1):
        if 0 <= other < data.joints:
            neighbour = np.nan_to_num(nominal_rad[index][:, other])
            columns += [neighbour, np.gradient(neighbour, t)]
        elif data.joints > 1:
            columns += [np.zeros_like(t), np.zeros_like(t)]
    if load_nm is not None:
        load = load_nm[index][:, joint]
        columns += [load, np.tanh(load / (np.std(load) + 1e-9)), load * rate]
    return np.stack(columns, axis=1)
