"""What the run loop is measured beside (``bench_loop.py``): a bare echo on each link, and a plain C loop over a pty."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import subprocess
import tty
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

JOINTS = 5
MULTICAST = "239.74.163.2"

C_SOURCE = r"""
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
int main(int argc, char **argv) {
    if (argc < 6) return 2;
    int fd = atoi(argv[1]); double interval = 1 / atof(argv[2]); int ticks = atoi(argv[3]);
    size_t out = (size_t)atoi(argv[4]), in = (size_t)atoi(argv[5]);
    char buffer[4096]; memset(buffer, 1, sizeof buffer);
    prctl(PR_SET_TIMERSLACK, 1);
    struct sched_param priority = {10};
    sched_setscheduler(0, SCHED_FIFO, &priority); /* as the run loop does; nothing without the permission */
    double origin = now() + 0.01;
    for (int k = 0; k < ticks; k++) {
        double deadline = origin + k * interval;
        struct timespec at = {(time_t)deadline, (long)((deadline - (time_t)deadline) * 1e9)};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL)) {}
        double start = now(); size_t got = 0;
        if (write(fd, buffer, out) < 0) return 1;
        while (got < in) {
            struct pollfd p = {fd, POLLIN, 0};
            if (poll(&p, 1, 1000) <= 0) return 1;
            ssize_t n = read(fd, buffer + 1024, sizeof buffer - 1024);
            if (n <= 0) return 1;
            got += (size_t)n;
        }
        printf("%.9f %.9f\n", start - deadline, now() - start);
        int behind = (int)((now() - deadline) / interval);
        if (behind > 0) k += behind - 1 < 0 ? 0 : behind - 1;
    }
    return 0;
}
"""


@dataclass
class Figures:
    """Lateness and round trip of every tick, in s."""

    lateness: list[float] = field(default_factory=list)
    trips: list[float] = field(default_factory=list)
    lost: int = 0

    def row(self, interval: float) -> dict[str, Any]:
        import numpy as np

        trips, lateness = np.array(self.trips) * 1e6, np.array(self.lateness)
        late = int((lateness > 0.5 * interval).sum())
        return {
            "ticks": len(lateness),
            "trip_us": [round(float(v)) for v in (*np.percentile(trips, [50, 99]), trips.max())],
            "lateness_us": [
                round(float(v) * 1e6) for v in (*np.percentile(lateness, [50, 99]), lateness.max())
            ],
            "late": late,
            "late_per_10000": round(1e4 * late / max(len(lateness), 1), 2),
            "lost": self.lost,
        }


def request_and_answer() -> tuple[list[Any], list[Any]]:
    """The frames of one tick out, and of the simulated board's answer (state, measured, applied, pose)."""
    from firmware_protocol.assembly import sample_messages, setpoint_messages
    from firmware_protocol.catalogue import Mode, PoseMotion, PosePosition, State, encode

    out = [encode(m) for m in setpoint_messages(1, [0.1] * JOINTS, 0.01)]
    messages = [
        *sample_messages(State(1, 1, Mode.ARMED, 1), [1] * JOINTS, [0.1] * JOINTS),
        PosePosition(1, 0.1, 0.1),
        PoseMotion(1, 0.1, 0.1),
    ]
    return out, [encode(m) for m in messages]


def serve_echo(kind: str) -> None:
    """The process that only answers, as urgently as the board does."""
    from snakebot.clock import urgent

    with urgent():
        _answer(kind)


def _answer(kind: str) -> None:
    from firmware_protocol.framing import pack_all

    request, answer = request_and_answer()
    if kind == "pty":
        master, slave = os.openpty()
        tty.setraw(slave)
        print(os.ttyname(slave), flush=True)
        size, reply, got = len(pack_all(request)), pack_all(answer), 0
        while True:
            got += len(os.read(master, 4096))
            if got >= size:
                got -= size
                os.write(master, reply)
    import can

    if kind == "slcan":
        master, slave = os.openpty()
        tty.setraw(slave)
        print(os.ttyname(slave), flush=True)
        lines = b"".join(b"t%03X%d%s\r" % (f.id, len(f.data), f.data.hex().upper().encode()) for f in answer)
        count = 0
        while True:
            data = os.read(master, 4096)
            count += data.count(b"t")
            if count >= len(request):
                count -= len(request)
                os.write(master, lines)
    ours = {frame.id for frame in answer}
    with can.Bus(interface="udp_multicast", channel=MULTICAST) as bus:
        print("ready", flush=True)
        count = 0
        while True:
            message = bus.recv(1.0)
            if message is None or message.arbitration_id in ours:
                continue
            count += 1
            if count == len(request):
                count = 0
                for frame in answer:
                    bus.send(can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False))


def echo_loop(kind: str, where: str, rate: float, seconds: float) -> Figures:
    """The host's side of the bare echo."""
    from firmware_protocol.framing import pack_all
    from snakebot.clock import MonotonicClock, urgent

    request, answer = request_and_answer()
    exchange: Callable[[], bool]
    with contextlib.ExitStack() as stack:
        stack.enter_context(urgent())
        if kind == "pty":
            fd = os.open(where, os.O_RDWR | os.O_NOCTTY)
            stack.callback(os.close, fd)
            out, size = pack_all(request), len(pack_all(answer))

            def exchange() -> bool:
                os.write(fd, out)
                got = 0
                while got < size:
                    if not select.select([fd], [], [], 0.1)[0]:
                        return False
                    got += len(os.read(fd, 4096))
                return True
        else:
            import can

            if kind == "slcan":
                bus: Any = can.Bus(interface="slcan", channel=where, bitrate=1_000_000, sleep_after_open=0)
            else:
                bus = can.Bus(interface="udp_multicast", channel=MULTICAST)
            stack.callback(bus.shutdown)
            messages = [can.Message(arbitration_id=f.id, data=f.data, is_extended_id=False) for f in request]
            ours = {frame.id for frame in request}

            def exchange() -> bool:
                for message in messages:
                    bus.send(message)
                got = 0
                while got < len(answer):
                    message = bus.recv(0.1)
                    if message is None:
                        return False
                    got += message.arbitration_id not in ours
                return True

        clock, figures = MonotonicClock(), Figures()
        origin, k = clock.now_s() + 0.05, 0
        while k < seconds * rate:
            deadline = origin + k / rate
            clock.sleep_until(deadline)
            start = clock.now_s()
            figures.lateness.append(start - deadline)
            if exchange():
                figures.trips.append(clock.now_s() - start)
            else:
                figures.lost += 1
            k = max(k + 1, int((clock.now_s() - origin) * rate))
    return figures


def build_c(folder: Path) -> Path | None:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    source, program = folder / "control.c", folder / "control"
    source.write_text(C_SOURCE)
    subprocess.run([compiler, "-O2", "-o", program, source], check=True)
    return program


def c_loop(program: Path, where: str, rate: float, seconds: float) -> Figures:
    from firmware_protocol.framing import pack_all

    request, answer = request_and_answer()
    fd = os.open(where, os.O_RDWR | os.O_NOCTTY)
    try:
        result = subprocess.run(
            [
                program,
                str(fd),
                str(rate),
                str(int(seconds * rate)),
                str(len(pack_all(request))),
                str(len(pack_all(answer))),
            ],
            stdout=subprocess.PIPE,
            text=True,
            pass_fds=[fd],
            check=True,
        )
    finally:
        os.close(fd)
    figures = Figures()
    for line in result.stdout.splitlines():
        lateness, trip = map(float, line.split())
        figures.lateness.append(lateness)
        figures.trips.append(trip)
    return figures
