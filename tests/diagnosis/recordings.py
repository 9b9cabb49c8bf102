"""Recordings of real servos, where they are at hand, and quick answers about them: each asked for once a suite."""

from __future__ import annotations

import fcntl
import json
import warnings
from pathlib import Path
from typing import Any

import pytest

from snakebot.diagnosis import diagnose
from snakebot.runlog import read_session

REAL = Path(__file__).parents[2].parent / "shared" / "realdata"
AT_HAND = pytest.mark.skipif(not REAL.is_dir(), reason="../shared/realdata is not here")
# What a suite has time for: so101_arm takes minutes; tools/invariants.py judges an answer about that, too.
RECORDINGS = (
    "xl330_pendulum/kp_100",
    "xl330_pendulum/kp_200",
    "xl330_pendulum/kp_400",
    "xl330_pendulum/kp_800",
    "pwm_servo_pendulum/without_weight",
    "pwm_servo_pendulum/with_weight",
)


class Answers:
    """Answers as JSON files in a folder that all workers of a suite share."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(exist_ok=True)

    def path(self, name: str) -> Path:
        """The answer about a recording; whoever asks first diagnoses, others wait."""
        path = self.folder / f"{name.replace('/', '_')}.json"
        with path.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not path.exists():
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    found = diagnose(read_session(REAL / name), quick=True)
                path.write_text(json.dumps(found.to_mapping()))
        return path

    def about(self, name: str) -> dict[str, Any]:
        answer: dict[str, Any] = json.loads(self.path(name).read_text())
        return answer


@pytest.fixture(scope="session")
def answers(of_all_workers: Path) -> Answers:
    return Answers(of_all_workers / "answers")
