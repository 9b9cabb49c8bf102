"""Writes ticks as a run loop does, in a process of its own, until it is killed or the disk is full.

``kill PATH SEED``: a tick about every 2 ms; each tick that was handed over is told on stdout as 16 bytes (number,
monotonic ns). ``close PATH SEED``: writes 400 ticks, says so, closes, says so. ``fill PATH SEED``: writes until the log
raises, then prints as JSON what it said and how many ticks had been handed over.
"""

from __future__ import annotations

import json
import os
import struct
import sys
import time
from pathlib import Path

from runlog_samples import ROBOT, START_NS, make_ticks

from snakebot.errors import LogError
from snakebot.runlog import RunWriter, read_log

MOST = 4000


def main(what: str, path: Path, seed: int) -> None:
    ticks = make_ticks(MOST, seed=seed)
    writer = RunWriter(path, ROBOT, start_time_ns=START_NS)
    if what == "kill":
        for tick in ticks:
            writer.tick(tick)
            os.write(1, struct.pack("<qq", tick.sequence, time.monotonic_ns()))
            time.sleep(0.002)
    elif what == "close":
        for tick in ticks[:400]:
            writer.tick(tick)
        os.write(1, b"closing")
        writer.close()
        os.write(1, b"closed")
    else:
        handed_over = 0
        try:
            for tick in ticks:
                writer.tick(tick)
                handed_over += 1
                time.sleep(0.002)
            said = ""
        except LogError as error:
            said = str(error)
        closed_as = writer.close()
        log = read_log(closed_as)
        print(
            json.dumps(
                {
                    "said": said,
                    "handed_over": handed_over,
                    "closed_as": closed_as.name,
                    "rows": log.sequence.tolist(),
                    "measured": log.measured_rad.tolist(),
                    "problems": log.problems,
                }
            )
        )


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
