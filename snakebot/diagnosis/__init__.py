"""Diagnosis of the gap between robot and simulation: where, which effect, how far it shrinks. See docs/diagnosis.md.

``engine.diagnose`` leads a session through the rooms, one after the other; each hands on a frozen record::

    Session -> evidence -> fit -> search -> verdict -> proposal -> Diagnosis -> show

A room imports only rooms before it. ``options`` is what a user may ask for, ``result`` the schema of the answer. A
constant at the head of a file was chosen, on sessions set aside for tuning, unless its comment says how it was
measured. Names load on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from snakebot.diagnosis.engine import diagnose
    from snakebot.diagnosis.result import Diagnosis, json_schema

_HOME = {"Diagnosis": "result", "diagnose": "engine", "json_schema": "result"}

__all__ = ["Diagnosis", "diagnose", "json_schema"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
