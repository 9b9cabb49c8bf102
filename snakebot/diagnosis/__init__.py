"""Diagnosis of the gap between robot and simulation: where, which effect, how far it shrinks. See docs/diagnosis.md.

``engine.diagnose`` takes a session through the rooms, one after the other; each returns a frozen record to the next::

    Session -> evidence -> fit -> search -> verdict -> proposal -> Diagnosis -> show

A room imports only rooms before it. ``options`` is what a user may ask for, ``result`` the schema of the answer,
``sizes`` what is little, much or clear wherever that is asked. A constant at the head of a file says its unit and where
it comes from: chosen (on sessions set aside for tuning), measured, or by definition. Names load on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.lazy import names_from

if TYPE_CHECKING:
    from snakebot.diagnosis.engine import diagnose
    from snakebot.diagnosis.result import Diagnosis, json_schema

_HOME = {"Diagnosis": "result", "diagnose": "engine", "json_schema": "result"}

__all__ = ["Diagnosis", "diagnose", "json_schema"]

__getattr__ = names_from(__name__, _HOME)
