"""A run log in memory: numpy arrays, a row a record."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import AnyArray, Bools, Floats, Ints
from snakebot.errors import BadInputError
from snakebot.nearest import not_known
from snakebot.robot import Robot
from snakebot.runlog.naming import PART_SUFFIX, SUFFIX
from snakebot.runlog.plausible import plausible
from snakebot.runlog.records import Event, RawFrame
from snakebot.runlog.run import CUT_SHORT, Run
from snakebot.safe_yaml import NO_LINES, Lines

if TYPE_CHECKING:
    import pandas as pd

    from snakebot.gait import Gait


# Columns of tables and runs, and the field of /steering that each holds.
STEERING_COLUMNS = {
    "heading_error_rad": "heading_error_rad",
    "cross_track_m": "cross_track_m",
    "steering_offset_rad": "offset_rad",
}


class NoTicksError(BadInputError):
    """A log without a tick: of a run that was refused, or killed at its start."""


@dataclass(frozen=True, eq=False)
class RunLog:
    """What ``read_log`` returns: N ticks of k joints, P poses. nan = missing."""

    path: Path
    robot: Robot
    metadata: Mapping[str, Any]
    attachments: Mapping[str, bytes]
    complete: bool  # the log was closed properly
    problems: tuple[str, ...]  # what was damaged and left out; empty for a whole log

    sequence: Ints  # (N,)
    t_s: Floats  # (N,) host time since the run's start
    host_time_ns: Ints  # (N,) wall clock
    setpoint_rad: Floats  # (N, k); nan = servo off
    sent_rad: Floats  # (N, k) after limits
    applied_rad: Floats  # (N, k) all nan where the board reports none
    measured_rad: Floats  # (N, k); nan = sample lost
    board_time_us: Floats  # (N,) exact to 2**53 us
    latency_s: Floats  # (N,)
    late: Bools  # (N,)

    pose_t_s: Floats  # (P,)
    pose: Floats  # (P, 3) x_m, y_m, heading_rad
    pose_speed_m_s: Floats  # (P,)

    events: tuple[Event, ...]
    link_t_s: Floats  # (L,)
    link: Mapping[str, Floats]  # counter -> (L,)
    telemetry_t_s: Floats  # (M,)
    telemetry: Mapping[str, Floats]  # supply_v, current_1_a, ... -> (M,)
    frames: tuple[RawFrame, ...]
    steering_t_s: Floats = field(default_factory=lambda: np.empty(0))  # (S,)
    steering: Mapping[str, Floats] = field(default_factory=dict)  # heading_error_rad, offset_rad, ... -> (S,)

    @property
    def joints(self) -> int:
        return int(self.setpoint_rad.shape[1])

    @property
    def name(self) -> str:
        return self.path.name.removesuffix(PART_SUFFIX).removesuffix(SUFFIX)

    @property
    def gait(self) -> Gait | None:
        """The commanded gait, where the metadata names one.

        Raises:
            BadInputError: what it names is no gait.
        """
        return gait_from_mapping(self.metadata.get("gait"), str(self.path))

    @property
    def forward_speed_m_s(self) -> float | None:
        return self.number("forward_speed_m_s")

    @property
    def ended(self) -> str | None:
        """How the run ended; None where that is not known."""
        return ended(self.metadata, self.complete)

    @property
    def start_time_ns(self) -> int:
        """Wall clock at t_s = 0; 0 where the log does not say."""
        return int(self.number("start_time_ns") or 0)

    def number(self, key: str) -> float | None:
        """A number of the metadata; None where it is missing or no finite number (a stranger wrote the log)."""
        value = self.metadata.get(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            return None
        return value

    def pose_at(self, t_s: Floats) -> Floats:
        """Pose at these times (N, 3), linear between poses; nan before the first and after the last.

        The heading is unwrapped, so that it is continuous.
        """
        out = np.full((t_s.size, 3), np.nan)
        order = np.argsort(self.pose_t_s, kind="stable")
        for index in range(3):
            known = order[np.isfinite(self.pose[order, index])]
            if known.size:
                values = self.pose[known, index]
                values = np.unwrap(values) if index == 2 else values
                out[:, index] = np.interp(t_s, self.pose_t_s[known], values, left=np.nan, right=np.nan)
        return out

    def telemetry_at(self, t_s: Floats) -> dict[str, Floats]:
        """Readings at these times, each the latest known then; nan before the first."""
        return {name: _held(self.telemetry_t_s, values, t_s) for name, values in self.telemetry.items()}

    def steering_at(self, t_s: Floats) -> dict[str, Floats]:
        """Course errors and offset at these times, each as last decided, by the names of ``STEERING_COLUMNS``."""
        return {
            column: _held(self.steering_t_s, self.steering[name], t_s)
            for column, name in STEERING_COLUMNS.items()
            if name in self.steering and np.isfinite(self.steering[name]).any()
        }

    def to_run(self) -> Run:
        """The run as analysis and diagnosis take it: the command is what was sent after limits.

        Of ticks with the same time (no run of ours has any) the first is taken, and none without a time.

        Raises:
            NoTicksError: the log holds none.
            BadInputError: it holds numbers that no robot reaches.
        """
        timed = np.isfinite(self.t_s)  # those without a time are the last: ticks are ordered by it
        if not timed.any():
            raise NoTicksError(f"{self.path}: the log holds no ticks")
        keep = timed & np.concatenate(([True], self.t_s[1:] > self.t_s[:-1]))
        t_s = self.t_s[keep]
        pose = self.pose_at(t_s) if self.pose_t_s.size else None
        applied = self.applied_rad[keep]
        extra: dict[str, AnyArray] = {
            "sequence": self.sequence[keep],
            "board_time_us": self.board_time_us[keep],
            "latency_s": self.latency_s[keep],
            "late": self.late[keep],
            **self.telemetry_at(t_s),
            **self.steering_at(t_s),
        }
        run = Run(
            name=self.name,
            t_s=t_s,
            command_rad=self.sent_rad[keep],
            measured_rad=self.measured_rad[keep],
            applied_rad=applied if np.isfinite(applied).any() else None,
            pose=pose,
            gait=self.gait,
            forward_speed_m_s=self.forward_speed_m_s,
            extra=extra,
            metadata=self.metadata if self.ended is None else {**self.metadata, "ended": self.ended},
        )
        return plausible(run, str(self.path))

    def columns(self) -> dict[str, AnyArray]:
        """The ticks as flat named columns, each (N,): what the CSV and Parquet exports hold."""
        flat: dict[str, AnyArray] = {
            "t_s": self.t_s,
            "sequence": self.sequence,
            "host_time_ns": self.host_time_ns,
        }
        for prefix, array in (
            ("setpoint", self.setpoint_rad),
            ("cmd", self.sent_rad),
            ("applied", self.applied_rad),
            ("enc", self.measured_rad),
        ):
            flat.update({f"{prefix}_{joint + 1}_rad": array[:, joint] for joint in range(self.joints)})
        flat.update(board_time_us=self.board_time_us, latency_s=self.latency_s, late=self.late)
        if self.pose_t_s.size:
            pose = self.pose_at(self.t_s)
            flat.update(x_m=pose[:, 0], y_m=pose[:, 1], heading_rad=pose[:, 2])
        return {**self.telemetry_at(self.t_s), **self.steering_at(self.t_s), **flat}

    def to_pandas(self) -> pd.DataFrame:
        """The ticks as a DataFrame (needs pandas: ``pip install snakebot[pandas]``)."""
        try:
            import pandas as pd
        except ImportError:
            raise BadInputError("pandas is not installed: pip install 'snakebot[pandas]'") from None
        return pd.DataFrame(self.columns())


def _held(known_s: Floats, values: Floats, t_s: Floats) -> Floats:
    """Values at these times, each the latest known then; nan before the first."""
    order = np.argsort(known_s, kind="stable")
    known = order[np.isfinite(values[order])]
    if not known.size:
        return np.full(t_s.size, np.nan)
    at = np.searchsorted(known_s[known], t_s, side="right") - 1
    return np.where(at >= 0, values[known][at], np.nan)


def ended(metadata: Mapping[str, Any], complete: bool) -> str | None:
    """``finished``, ``interrupted``, ``error: ...`` as the log says, or ``cut short`` where it could not."""
    said = metadata.get("ended")
    if isinstance(said, str):
        return said
    return None if complete and not metadata.get("recovered") else CUT_SHORT


_GAIT_KEYS = ("alpha_deg", "beta_deg", "omega_rad_s", "offset_deg")
_SHARES = "amplitudes"  # of each joint, as a share of alpha


def gait_from_mapping(data: object, where: str, lines: Lines = NO_LINES) -> Gait | None:
    """A gait from ``{alpha_deg, beta_deg, omega_rad_s[, offset_deg][, amplitudes]}``; None for None.

    Raises:
        BadInputError: a key is missing, unknown or not a finite number.
    """
    if data is None:
        return None
    from snakebot.gait import Gait
    from snakebot.gait.named import shares_of

    if not isinstance(data, Mapping):
        raise BadInputError(f"{where}: gait: needs alpha_deg, beta_deg and omega_rad_s")
    values, shares = {"offset_deg": 0.0}, ()  # type: tuple[dict[str, float], tuple[float, ...]]
    for key, value in data.items():
        if key == _SHARES:
            shares = shares_of(value, f"{where}: gait: {lines.of(key)}")
            continue
        if key not in _GAIT_KEYS:
            raise BadInputError(
                f"{where}: gait: {lines.of(key)}{not_known(key, (*_GAIT_KEYS, _SHARES), 'a gait')}"
            )
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
            raise BadInputError(f"{where}: gait: {lines.of(key)}{key}: not a finite number (found {value!r})")
        values[key] = float(value)
    missing = [key for key in _GAIT_KEYS if key not in values]
    if missing:
        raise BadInputError(f"{where}: gait: {lines.of()}{missing[0]} is missing")
    try:
        return Gait.from_degrees(
            values["alpha_deg"],
            values["beta_deg"],
            values["omega_rad_s"],
            values["offset_deg"],
            shares=shares,
        )
    except BadInputError as error:
        raise BadInputError(f"{where}: {error}") from None


def gait_to_mapping(gait: Gait) -> dict[str, Any]:
    """The gait as it stands in metadata and in session.yaml."""
    mapping: dict[str, Any] = {
        "alpha_deg": round(float(np.rad2deg(gait.alpha_rad)), 9),
        "beta_deg": round(float(np.rad2deg(gait.beta_rad)), 9),
        "omega_rad_s": float(gait.omega_rad_s),
    }
    if gait.offset_rad:
        mapping["offset_deg"] = round(float(np.rad2deg(gait.offset_rad)), 9)
    if gait.shares:
        mapping[_SHARES] = list(gait.shares)
    return mapping
