"""Set-points are made before their deadline, sent on it, and lost to nobody when they are slept through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from lag_plant import LagPlant

from firmware_protocol.catalogue import Latch, decode
from snakebot.board import Board, MadeSetpoint
from snakebot.clock import VirtualClock
from snakebot.control.loop import RunLoop
from snakebot.control.making import Maker
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import load_robot
from snakebot.softboard import InProcessLink, SoftBoard

ROBOT = load_robot("penn_state")
INTERVAL_S = 0.01
MOTION = GaitMotion(Gait.from_degrees(66, 80, 2), ROBOT.joints, 8, 1, [0.0] * ROBOT.joints)


def connected() -> tuple[Board, VirtualClock]:
    clock = VirtualClock()
    sim = SoftBoard(ROBOT, plant=LagPlant(ROBOT.joints, ROBOT.servo.time_constant_s))
    board = Board(InProcessLink(sim, clock), clock)
    board.connect()
    return board, clock


def latch(made: MadeSetpoint) -> Latch:
    message = decode(made.frames[-1])
    assert isinstance(message, Latch)
    return message


def test_a_tick_is_made_before_its_deadline_and_sent_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    board, clock = connected()
    made_s: list[float] = []
    sent_s: list[float] = []
    make, send = board.make_setpoint, board.send_made

    def noted_make(*arguments: Any) -> MadeSetpoint:
        made_s.append(clock.now_s())
        return make(*arguments)

    def noted_send(*arguments: Any) -> None:
        sent_s.append(clock.now_s())
        send(*arguments)

    monkeypatch.setattr(board, "make_setpoint", noted_make)
    monkeypatch.setattr(board, "send_made", noted_send)
    motion = GaitMotion(Gait.from_degrees(10, 80, 2), ROBOT.joints, 1, 0.4, [0.0] * ROBOT.joints)
    loop = RunLoop(board, ROBOT, lambda _: motion, rate_hz=100, clock=clock, amplitude_rad=0.5)
    loop.run()
    assert len(sent_s) == 101
    for number, (made, sent) in enumerate(zip(made_s[1:], sent_s[1:], strict=False), 1):
        assert sent == pytest.approx(sent_s[0] + number * INTERVAL_S, abs=1e-9)
        assert 1e-4 < sent - made < 1e-3


def test_one_that_is_slept_through_leaves_its_number_and_its_time_to_the_next() -> None:
    board, _ = connected()
    maker = Maker(board, ROBOT, INTERVAL_S, Progress(8.0, TrackingSoFar(ROBOT.joints, 1.0)))
    maker.start([0.0] * ROBOT.joints)
    first = maker.make(MOTION, 0)
    board.send_made(first.made)
    maker.sent(first)
    slept_through = maker.make(MOTION, 1)
    instead = maker.make(MOTION, 4)
    assert instead.made.sequence == slept_through.made.sequence == (first.made.sequence + 1) & 0xFFFF
    assert latch(slept_through.made).interval_s == pytest.approx(INTERVAL_S)
    assert latch(instead.made).interval_s == pytest.approx(4 * INTERVAL_S), "since the one that was sent"
    assert instead.made.angles_rad == pytest.approx(MOTION.angles(4 * INTERVAL_S), abs=0.51e-4)


def test_what_is_made_keeps_the_limits_over_ticks_that_are_not_sent() -> None:
    board, _ = connected()
    progress = Progress(8.0, TrackingSoFar(ROBOT.joints, 1.0))
    maker = Maker(board, ROBOT, INTERVAL_S, progress)
    start = [1.0] * ROBOT.joints
    maker.start(start)  # far from where the motion begins: the limits have to lead there
    before: Sequence[float] = start
    before_tick = -1
    for tick in (0, 1, 2, 5, 6, 9, 10, 11, 20):
        ready = maker.make(MOTION, tick)
        span_s = (tick - before_tick) * INTERVAL_S
        for limit, now, then in zip(ROBOT.speed_limit_rad_s, ready.made.angles_rad, before, strict=True):
            assert abs(now - then) <= limit * span_s + 2e-4
        if tick % 2 == 0:
            board.send_made(ready.made)
            maker.sent(ready)
        before, before_tick = ready.made.angles_rad, tick
    assert progress.clamped > 0
