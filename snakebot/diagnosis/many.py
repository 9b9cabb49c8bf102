"""Many sessions, each diagnosed for itself: here, or by the workers of a cluster."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from snakebot.cluster import Workers
from snakebot.diagnosis.engine import diagnose
from snakebot.errors import BadInputError
from snakebot.runlog import Session

SessionsCallback = Callable[[int, int], None]  # sessions done, sessions in all


@dataclass(frozen=True)
class SessionAnswer:
    """What came of one session: a verdict as ``diagnose --json`` writes it, or one line why there is none."""

    name: str
    verdict: Mapping[str, Any] | None = None
    refused: str = ""

    def row(self) -> dict[str, Any]:
        """Plain values: a row of the table. The verdict is in it whole, as JSON."""
        found = self.verdict or {}
        causes = found.get("causes", [])
        closure = (found.get("closure") or {}).get("joint_angle") or {}
        return {
            "session": self.name,
            "refused": self.refused,
            "verdict": found.get("verdict", ""),
            "causes": [cause["specification"] for cause in causes],
            "probability": [float(cause["probability"]) for cause in causes],
            "rms_before_rad": closure.get("rms_before"),
            "rms_after_rad": closure.get("rms_after"),
            "closed": closure.get("closed"),
            "json": json.dumps(self.verdict) if self.verdict is not None else "",
        }


def answer(name: str, session: Session, options: Mapping[str, Any]) -> SessionAnswer:
    """One session: what a worker is asked. ``options``: those of ``diagnose``."""
    try:
        found = diagnose(session, **options)
    except BadInputError as error:
        return SessionAnswer(name, refused=str(error))
    return SessionAnswer(name, found.to_mapping(first=False))


def diagnose_many(
    sessions: Mapping[str, Session | BadInputError],
    options: Mapping[str, Any],
    workers: Workers,
    progress: SessionsCallback | None = None,
) -> list[SessionAnswer]:
    """Verdicts in the order of the sessions; one that cannot be read or diagnosed says why and stops no other.

    Args:
        sessions: by name, or why one cannot be read.
        options: those of ``diagnose``, the same for all.
    """
    pieces = {
        name: (name, session, dict(options))
        for name, session in sessions.items()
        if not isinstance(session, BadInputError)
    }
    found = {
        name: SessionAnswer(name, refused=str(error))
        for name, error in sessions.items()
        if isinstance(error, BadInputError)
    }
    for name, one in workers.results(answer, pieces):
        found[name] = one
        if progress is not None:
            progress(len(found), len(sessions))
    return [found[name] for name in sessions]
