"""Findings of ``snakebot doctor``, and what it looks at on this computer."""

from __future__ import annotations

import os
import platform
import time
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from snakebot.clock import Clock

_SLEEPS = 300
_INTERVAL_S = 0.002
_GOOD_LATENESS_S = 0.0005
_SLOW_CLOCKS = ("hpet", "acpi_pm", "jiffies", "refined-jiffies")


class Status(StrEnum):
    """How good a finding is. ``INFO`` is neither."""

    OK = "ok"
    INFO = "info"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at: what was found, and what to do about it (empty where nothing is to be done)."""

    what: str
    status: Status
    found: str
    advice: str = ""


def read_text(path: Path) -> str | None:
    """A small file's text, or None where there is none to read."""
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return None


def percentile(sorted_values: list[float], share: float) -> float:
    """The value below which this share of them lies (nearest rank)."""
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]


def check_host(clock: Clock) -> list[Finding]:
    """Clock source, timer, processor speed: whether this computer can keep a tick."""
    return [_versions(), *clock_source(), governor(), _timer(clock)]


def _versions() -> Finding:
    from importlib.metadata import version

    found = ", ".join(f"{name} {version(name)}" for name in ("snakebot", "pyserial", "python-can"))
    return Finding(
        "versions", Status.INFO, f"{found}, Python {platform.python_version()}, {platform.platform()}"
    )


def clock_source(
    folder: Path = Path("/sys/devices/system/clocksource/clocksource0"),
) -> list[Finding]:
    """What the kernel reads time from; nothing where it does not say."""
    source = read_text(folder / "current_clocksource")
    if source is None:
        return []
    if source in _SLOW_CLOCKS:
        better = read_text(folder / "available_clocksource") or ""
        advice = f"slow to read; available: {better}; see dmesg for why the kernel left tsc"
        return [Finding("clock source", Status.WARN, source, advice)]
    resolution_ns = time.clock_getres(time.CLOCK_MONOTONIC) * 1e9
    return [Finding("clock source", Status.OK, f"{source}, resolution {resolution_ns:.0f} ns")]


def governor(path: Path = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")) -> Finding:
    """Whether the processor may run as fast as it can."""
    name = read_text(path)
    if name == "powersave":
        advice = "late ticks? `sudo cpupower frequency-set -g performance`"
        return Finding("processor", Status.WARN, f"{os.cpu_count()} cores, governor powersave", advice)
    return Finding("processor", Status.OK, f"{os.cpu_count()} cores, governor {name or 'not switchable'}")


def _timer(clock: Clock) -> Finding:
    """How late this computer wakes a sleeper, over 0.6 s."""
    lateness = []
    for _ in range(_SLEEPS):
        deadline_s = clock.now_s() + _INTERVAL_S
        clock.sleep_until(deadline_s)
        lateness.append(clock.now_s() - deadline_s)
    lateness.sort()
    p99_s = percentile(lateness, 0.99)
    found = (
        f"wakes {1e6 * percentile(lateness, 0.5):.0f} us late (median), {1e6 * p99_s:.0f} us (p99), "
        f"{1e6 * lateness[-1]:.0f} us (worst of {_SLEEPS})"
    )
    if p99_s <= _GOOD_LATENESS_S:
        return Finding("timer", Status.OK, found)
    rate = 0.5 / p99_s
    advice = f"ticks stay on time up to about {rate:.0f} Hz: close other programs, or lower --rate"
    return Finding("timer", Status.WARN, found, advice)
