"""What ``snakebot doctor`` looks at on this computer: versions, clock source, processor, timer."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path

from snakebot.clock import Clock
from snakebot.doctor.finding import Finding, Status, percentile, read_text

_SLEEPS = 300  # chosen: 0.6 s in all, and the 99th percentile is the third worst
_INTERVAL_S = 0.002  # of a sleep: a tick at 500 Hz
_GOOD_LATENESS_S = 0.0005  # chosen: a twentieth of a tick at 100 Hz
_SLOW_CLOCKS = ("hpet", "acpi_pm", "jiffies", "refined-jiffies")


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
