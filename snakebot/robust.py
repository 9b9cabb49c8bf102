"""Spread of samples that a few bad ones do not move."""

from __future__ import annotations

# Standard deviation of normal samples over their median absolute deviation: 1 / 0.6745, by definition.
MAD_TO_STD = 1.4826
# Standard deviations to either side of a normal distribution's 95 % interval, by definition.
SIGMAS_95 = 1.96
