"""Speed and acceleration of a stream of set-points over windows of any length: a little too much a tick adds up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SPANS = (1, 2, 3, 5, 10, 20, 30, 50, 100, 200)  # ticks


def nearest_to_limits(
    t_s: Sequence[float],
    angle_rad: Sequence[float],
    speed_rad_s: float,
    acceleration_rad_s2: float,
    slack_rad: float,
    where: str = "",
) -> tuple[float, float]:
    """Holds one joint's angles against its limits, over all windows of ``SPANS`` ticks.

    A path that keeps the limits goes no further than ``speed * W`` in a time W, and its mean speeds over two windows
    side by side, of lengths W and V, differ by no more than ``acceleration * (W + V) / 2``. An angle may lie
    ``slack_rad`` beside it, however short or long the window is.

    Returns:
        The largest speed and change of speed seen, as shares of what is allowed.

    Raises:
        AssertionError: a window beyond a limit.
    """
    t, x = np.asarray(t_s), np.asarray(angle_rad)
    worst = [0.0, 0.0]
    for span in SPANS:
        if len(x) <= 2 * span:
            break
        passed, way = t[span:] - t[:-span], x[span:] - x[:-span]
        speed = np.abs(way) / (speed_rad_s * passed + 2 * slack_rad + 1e-9)
        first, second = passed[:-span], passed[span:]
        change = np.abs(way[span:] / second - way[:-span] / first)
        rounding = 2 * slack_rad * (1 / first + 1 / second)
        change /= acceleration_rad_s2 * (first + second) / 2 + rounding + 1e-6
        for kind, (name, share) in enumerate((("speed", speed), ("acceleration", change))):
            at = int(np.argmax(share))
            assert share[at] <= 1, (
                f"{name} {where}: {share[at]:.3f} of what is allowed over {span} ticks from {t[at]:.4f} s"
            )
            worst[kind] = max(worst[kind], float(share[at]))
    return worst[0], worst[1]
