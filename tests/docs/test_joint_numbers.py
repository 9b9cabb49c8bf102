"""Joints and links are numbered from 1 at the tail, in the physics and in all that is written."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from snakebot.effects.prediction import predict
from snakebot.gait import Gait, GaitMotion
from snakebot.physics.chain import Chain
from snakebot.physics.model import ChainModel
from snakebot.robot import load_robot

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("docs", "firmware_protocol", "snakebot", "configs")
WRITTEN = (".md", ".py", ".yaml", ".js", ".html")
FROM_HEAD = re.compile(r"(joints?|ids?|one)\b[^.\n]*\b(from the head|at the head|head first)")


def test_a_positive_beta_drives_the_robot_towards_its_last_link() -> None:
    robot = load_robot("penn_state")
    assert robot.body is not None
    chain = Chain(ChainModel.from_body(robot.body), 1e-3)
    chain.reset([0.0] * robot.joints)
    assert (np.diff(chain.link_positions_m()[:, 0]) > 0).all()  # along the heading
    t = np.arange(0.0, 12.0, 0.05)
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), robot.joints, 14.0, 2.0)
    made = predict(robot, (), t, motion.sampled(t), quantise=False).motion
    assert made is not None
    assert made.speed_m_s[-60:].min() > 0.05


def test_no_text_counts_joints_from_the_head() -> None:
    wrong = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for folder in FOLDERS
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in WRITTEN
        for line in path.read_text(encoding="utf-8").splitlines()
        if FROM_HEAD.search(line.lower())
    ]
    assert not wrong
    assert "numbered from 1 at the tail" in (ROOT / "firmware_protocol" / "PROTOCOL.md").read_text("utf-8")
