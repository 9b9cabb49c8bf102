"""Numbers on a tool's command line: of which there must be at least one, times to wait, and shares."""

from __future__ import annotations

import argparse
import math


def at_least_one(text: str) -> int:
    """For ``type=`` of argparse, which puts the option's name in front of what is wrong."""
    try:
        number = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: not a whole number") from None
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: at least one")
    return number


def seconds(text: str) -> float:
    """The same for how long something may take, s: above zero and finite."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: not a time above zero, in seconds")
    return number


def share(text: str) -> float:
    """The same for a number from 0 to 1."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 <= number <= 1.0:
        raise argparse.ArgumentTypeError(f"{text}: not a share from 0 to 1")
    return number
