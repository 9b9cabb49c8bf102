"""Runs of one case over a real wire, each a ``snakebot run`` of its own, and the session that is made of them.

    wire_runs.py pty FOLDER < (pickled robot, seed, gaits)

FOLDER gets ``logs/run_NN.mcap`` and ``session/``; the last run repeats the first. Prints one JSON object: per run the
exit status, the tries it took and what the loop counted. A run that the board or the host ended because this computer
was too late is done again, as often as ``TRIES`` allows, and that is counted.
"""

from __future__ import annotations

import contextlib
import json
import pickle
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from blind.robot import Parameters

HERE = Path(__file__).resolve().parent
CAN_CHANNEL = "udp_multicast/239.74.163.2"
RUN_S, RAMP_S = 8.0, 1.0
TRIES = 4
# Exit statuses of snakebot run: board lost, board fault (its watchdog), this computer too late.
TOO_LATE = (4, 5, 7)
SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
# A CAN bus for this case alone: a network of its own, in which multicast reaches nobody else.
NETWORK = "ip link set lo up && ip route add 239.0.0.0/8 dev lo"


def own_network() -> list[str] | None:
    """How to start a command in a network of its own, or None where that cannot be."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return None
    for how in (["unshare", "-rn"], ["unshare", "-n"]):
        if subprocess.run([*how, "sh", "-c", NETWORK], capture_output=True, check=False).returncode == 0:
            return how
    return None


@contextlib.contextmanager
def board(parameters: Parameters, seed: int, carrier: str) -> Iterator[str]:
    """The blind robot behind a board in a process of its own; the port to use.

    Raises:
        RuntimeError: the board does not come up.
    """
    words = [sys.executable, str(HERE / "wire_board.py"), "pty" if carrier == "pty" else f"can:{CAN_CHANNEL}"]
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(pickle.dumps((parameters, seed)))
        process.stdin.flush()
        port = process.stdout.readline().decode().strip()
        if not port:
            raise RuntimeError("the blind robot's board did not come up")
        yield port
    finally:
        process.stdin.close()
        process.terminate()
        process.wait(20)


def run_gait(port: str, gait: tuple[float, float, float], log: Path) -> dict[str, Any]:
    """One run; what it said, its status and how often it was tried."""
    alpha, beta, omega = gait
    wave = ["--alpha", f"{alpha:g}", "--beta", f"{beta:g}", "--omega", f"{omega:g}"]
    words = [*SNAKEBOT, "run", *wave, "--duration", f"{RUN_S:g}", "--ramp", f"{RAMP_S:g}"]
    words += ["--port", port, "--yes", "--json", "--log", str(log)]
    for tries in range(1, TRIES + 1):
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode not in TOO_LATE:
            break
        if tries < TRIES:
            log.unlink(missing_ok=True)
    said = json.loads(done.stdout) if done.returncode == 0 else {}
    counted = {
        key: said.get(key)
        for key in ("ticks", "late", "skipped", "lost", "worst_lateness_ms", "round_trip_ms")
    }
    why = done.stderr.strip().splitlines()[-1:] if done.returncode else []
    return {"status": done.returncode, "tries": tries, "said": why, **counted}


def make_session(
    folder: Path, parameters: Parameters, seed: int, gaits: list[Any], carrier: str
) -> list[dict[str, Any]]:
    logs = folder / "logs"
    logs.mkdir(parents=True)
    results = []
    with board(parameters, seed, carrier) as port:
        for number, gait in enumerate([*gaits, gaits[0]], 1):
            results.append(run_gait(port, gait, logs / f"run_{number:02d}.mcap"))
            if results[-1]["status"] != 0:
                return results
    names = [str(path) for path in sorted(logs.glob("*.mcap"))]
    words = [*SNAKEBOT, "session", "make", str(folder / "session"), *names]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        results.append({"status": done.returncode, "tries": 1, "said": done.stderr.strip().splitlines()[-1:]})
    return results


def in_process_of_its_own(
    folder: Path, parameters: Parameters, seed: int, gaits: list[Any], carrier: str
) -> list[dict[str, Any]]:
    """``make_session`` in a new process; for CAN, in a network of its own.

    Raises:
        RuntimeError: it did not come to an end, or no network can be made.
    """
    words = [sys.executable, str(Path(__file__).resolve()), carrier, str(folder)]
    if carrier == "can":
        how = own_network()
        if how is None:
            raise RuntimeError("no network namespace can be made here (unshare, ip or the right to use them)")
        words = [*how, "sh", "-c", f'{NETWORK} && exec "$@"', "sh", *words]
    done = subprocess.run(words, input=pickle.dumps((parameters, seed, gaits)), capture_output=True)
    if done.returncode:
        raise RuntimeError(done.stderr.decode(errors="replace").strip()[-500:])
    results: list[dict[str, Any]] = json.loads(done.stdout)
    return results


def main() -> None:
    carrier, folder = sys.argv[1], Path(sys.argv[2])
    parameters, seed, gaits = pickle.load(sys.stdin.buffer)
    print(json.dumps(make_session(folder, parameters, seed, gaits, carrier)))


if __name__ == "__main__":
    main()
