"""A set of sealed cases: folders with random names, a plan, labels under seal. It knows no robot."""

from __future__ import annotations

import json
import secrets
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from stopped import nothing_new_once_stopped, worker_ends_at_ctrl_c

from blind.seal import seal

# The label of the case of a number, and what is to be taken out of the library when it is answered; the folder is
# written on the way. Called in another process.
MakeOne = Callable[[int, Path], tuple[dict[str, Any], str | None]]


class CannotMakeError(ValueError):
    """What is there does not fit; the message says what to do."""


def make_set(
    out: Path, head: dict[str, Any], numbers: Sequence[int], make_one: MakeOne, jobs: int | None
) -> None:
    """Make what is missing and seal it. ``head``: what was asked for, kept with the labels.

    Raises:
        CannotMakeError: begun with other options, a key without its seal, or ``out`` is no folder.
    """
    key = out.with_name(out.name + ".key")
    if (out / "labels.sealed").exists():
        print(f"{out} is sealed already: nothing to do; other options want another folder")
        return
    if key.exists():
        raise CannotMakeError(f"{key} is there, but {out} is not sealed: move one of them away")
    if out.exists() and not out.is_dir():
        raise CannotMakeError(f"{out}: not a folder")
    (out / "cases").mkdir(parents=True, exist_ok=True)
    # Until the seal is on, labels are kept outside of OUT, where the key will be.
    notes = out.with_name(out.name + ".unsealed.jsonl")
    done: dict[int, dict[str, Any]] = {}
    if notes.exists():
        first, *rest = (json.loads(line) for line in notes.read_text().splitlines() if line.endswith("}"))
        if first != head:
            raise CannotMakeError(f"{notes}: begun with other options; delete it and {out} to start anew")
        done = {int(entry["number"]): entry for entry in rest}
    else:
        notes.write_text(json.dumps(head) + "\n")
        notes.chmod(0o600)
    tokens = {str(entry["token"]) for entry in done.values()}
    for stray in (out / "cases").iterdir():  # finished or begun, but not noted when it was stopped
        if stray.name not in tokens:
            shutil.rmtree(stray)
    missing = [n for n in numbers if n not in done]
    tasks = {}
    begun = time.monotonic()
    workers = ProcessPoolExecutor(jobs, initializer=worker_ends_at_ctrl_c)
    with nothing_new_once_stopped(workers) as pool, notes.open("a") as file:
        secrets.SystemRandom().shuffle(missing)
        for n in missing:
            token = secrets.token_hex(6)
            tasks[pool.submit(_make, make_one, n, out / "cases" / token)] = n, token
        for i, ready in enumerate(as_completed(tasks), 1):
            (n, token), (label, exclude) = tasks[ready], ready.result()
            entry = {"number": n, "token": token, "label": label, "exclude": exclude}
            file.write(json.dumps(entry) + "\n")
            file.flush()
            done[n] = entry
            if sys.stderr.isatty() or i % 10 == 0 or i == len(tasks):
                print(
                    f"\rmade {i} of {len(tasks)}, {time.monotonic() - begun:.0f} s", end="", file=sys.stderr
                )
    print(file=sys.stderr)
    entries = sorted(done.values(), key=lambda e: str(e["token"]))
    plan = {str(e["token"]): e["exclude"] for e in entries}
    (out / "plan.json").write_text(json.dumps(plan, indent=1) + "\n")
    labels = {
        "made": head,
        "cases": {str(e["token"]): e["label"] for e in entries},
        "numbers": {str(e["token"]): e["number"] for e in entries},  # to build the robot anew
    }
    digest = seal(labels, out / "labels.sealed", key)
    (out / "seal.txt").write_text(f"{digest}  labels.sealed\n")
    notes.unlink()
    print(f"SHA-256 of the seal: {digest}")
    print(f"{len(entries)} cases in {out / 'cases'}; the key is in {key}")


def _make(make_one: MakeOne, number: int, folder: Path) -> tuple[dict[str, Any], str | None]:
    """The folder is there whole, or not at all."""
    temporary = folder.parent / f".{folder.name}"
    shutil.rmtree(temporary, ignore_errors=True)
    found = make_one(number, temporary)
    temporary.rename(folder)
    return found
