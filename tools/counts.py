"""A number on a tool's command line of which there must be at least one."""

from __future__ import annotations

import argparse


def at_least_one(text: str) -> int:
    """For ``type=`` of argparse, which puts the option's name in front of what is wrong."""
    try:
        number = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: not a whole number") from None
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: at least one")
    return number
