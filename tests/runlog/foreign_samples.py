"""Recordings as other programs write them, by their own libraries; all of one motion that is known."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from snakebot.arrays import Floats

NAMES = ("pan", "lift", "elbow")


def wave(
    samples: int = 300, rate_hz: float = 50.0, joints: int = 3, lag_s: float = 0.08
) -> tuple[Floats, Floats, Floats]:
    """Times (N,), commands and measured angles (N, k) in degrees: two sines, and the same somewhat later."""
    t_s = np.arange(samples) / rate_hz
    phase = np.arange(joints)
    late = np.maximum(t_s - lag_s, 0)[:, None]
    made = [
        30 * np.sin(2 * t[:, None] + phase) + 8 * np.sin(7 * t[:, None] + 2 * phase)
        for t in (t_s, late[:, 0])
    ]
    return t_s, made[0], made[1]


def lerobot_folder(
    folder: Path, version: str, episodes: Sequence[tuple[Floats, Floats]], fps: int = 30
) -> Path:
    """A dataset of LeRobot: the layout and the types of columns that version 2.1 or 3.0 writes."""
    (folder / "meta").mkdir(parents=True)
    width = episodes[0][0].shape[1]
    names: Any = [f"{name}.pos" for name in NAMES[:width]]
    feature = {
        "dtype": "float32",
        "shape": [width],
        "names": names if version == "v3.0" else {"motors": names},
    }
    path = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    if version == "v3.0":
        path = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    info = {
        "codebase_version": version, "fps": fps, "total_episodes": len(episodes), "data_path": path,
        "features": {"action": feature, "observation.state": feature, "timestamp": {"dtype": "float32", "shape": [1]}},
    }  # fmt: skip
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    (folder / "data" / "chunk-000").mkdir(parents=True)
    tables = []
    for number, (action, state) in enumerate(episodes):
        rows = np.arange(len(action))
        kind = pa.list_(pa.float32(), width)
        tables.append(
            pa.table(
                {
                    "action": pa.array(action.astype(np.float32).tolist(), kind),
                    "observation.state": pa.array(state.astype(np.float32).tolist(), kind),
                    "timestamp": (rows / fps).astype(np.float32),
                    "frame_index": rows,
                    "episode_index": np.full(len(rows), number),
                }
            )
        )
    if version == "v3.0":
        pq.write_table(pa.concat_tables(tables), folder / "data" / "chunk-000" / "file-000.parquet")
    else:
        for number, table in enumerate(tables):
            pq.write_table(table, folder / "data" / "chunk-000" / f"episode_{number:06d}.parquet")
    return folder
