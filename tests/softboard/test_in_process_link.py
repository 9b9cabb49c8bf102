"""The wire to a board in this process: the bytes of a serial line, in real or virtual time."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest
from board_rig import HOST, StillPlant, bench, samples

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    BoardHeartbeat,
    Counters,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    PoseMotion,
    PosePosition,
    State,
    decode,
    encode,
)
from snakebot.clock import MonotonicClock, VirtualClock
from snakebot.effects import EffectSpec
from snakebot.errors import LostBoardError
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, Servo, load_robot
from snakebot.softboard import InProcessLink, SoftBoard

TICK_S = 0.01


def wired(clock: VirtualClock | None = None, **link: Any) -> InProcessLink:
    board = SoftBoard(bench(), plant=StillPlant(5), boot_seed=1)
    return InProcessLink(board, clock or VirtualClock(), **link)


def say(link: InProcessLink, *messages: Message) -> None:
    link.send([encode(message) for message in messages])


def hear(link: InProcessLink, timeout_s: float = 0.0) -> list[Message]:
    return [decode(frame) for frame in link.receive(timeout_s)]


def test_an_answer_is_there_at_once() -> None:
    link = wired()
    link.receive(0.0)
    say(link, Ping(3))
    assert hear(link, 10.0) == [Pong(3, 0)]
    assert link.clock.now_s() == 0.0


def test_waiting_moves_a_virtual_clock_to_the_boards_next_word_or_the_end_of_the_wait() -> None:
    link = wired()
    link.receive(0.0)
    assert link.receive(0.04) == []
    assert link.clock.now_s() == pytest.approx(0.04)
    assert [m for m in hear(link, 5.0) if isinstance(m, BoardHeartbeat)]
    assert link.clock.now_s() == pytest.approx(0.1)


def test_real_time_waits_too() -> None:
    clock = MonotonicClock()
    link = InProcessLink(SoftBoard(bench(), plant=StillPlant(5)), clock)
    link.receive(0.0)
    before = clock.now_s()
    assert link.receive(0.02) == []
    assert clock.now_s() >= before + 0.02
    assert [m for m in hear(link, 1.0) if isinstance(m, BoardHeartbeat)]


def test_a_pulled_cable_raises_and_leaves_the_board_to_its_watchdog() -> None:
    link = wired()
    link.receive(0.0)
    say(link, ModeRequest(1, Mode.ARMED, HOST))
    link.unplug()
    for use in (lambda: link.send([]), lambda: link.receive(0.1)):
        with pytest.raises(LostBoardError, match="sim:"):
            use()
    link.board.advance(0.2)
    assert link.board.mode is Mode.FAULT
    link.close()
    link.close()


def test_noise_is_counted_on_both_ends_and_never_obeyed() -> None:
    noise = random.Random(4)

    def wire(data: bytes) -> bytes:
        hit = bytearray(data)
        for _ in range(1 + len(hit) // 40):
            hit[noise.randrange(len(hit))] ^= 1 << noise.randrange(8)
        return bytes(hit)

    link = wired(to_board=wire, to_host=wire)
    link.receive(0.0)
    counters = []
    for sequence in range(600):
        say(link, *setpoint_messages(sequence, [0.0] * 5, TICK_S), Ping(sequence))
        for frame in link.receive(TICK_S):
            message = decode(frame)
            if isinstance(message, Pong):
                assert message.nonce <= sequence
            if isinstance(message, Counters):
                counters.append(message)
        link.clock.sleep_until(link.clock.now_s() + TICK_S)
    assert link.statistics.corrupt > 0
    assert counters[-1].corrupt > 100
    assert counters[-1].received > 100


def run(link: InProcessLink, motion: GaitMotion) -> list[Message]:
    """Arm and stream a motion; everything that the board said."""
    clock = link.clock
    said = hear(link)
    say(link, ModeRequest(1, Mode.ARMED, HOST))
    start_s = clock.now_s()
    for tick in range(1, int(motion.duration_s / TICK_S)):
        clock.sleep_until(start_s + TICK_S * tick)
        say(link, *setpoint_messages(tick, list(motion.angles(TICK_S * tick)), TICK_S))
        said += hear(link)
    return said


def test_the_same_run_comes_out_the_same_to_the_last_bit() -> None:
    robot = load_robot("penn_state")
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), 5, 3.0, 1.0)
    specs = _effects(robot, "encoder_noise:std_deg=0.2", "command_loss:probability=0.1")
    runs = [
        run(InProcessLink(SoftBoard(robot, specs, seed, boot_seed=1), VirtualClock()), motion)
        for seed in (5, 5, 6)
    ]
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


def _effects(robot: Robot, *texts: str) -> list[EffectSpec]:
    from snakebot.effects import parse_effects

    return list(parse_effects(texts, robot))


def test_the_papers_gait_moves_at_the_papers_speed() -> None:
    """0.137 m/s at (66, 80, 2) with ideal tracking: the reference value of two independent engines."""
    robot = load_robot("penn_state").model_copy(update={"servo": Servo(time_constant_s=0.0)})
    period_s = math.pi
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), 5, 8 * period_s, period_s)
    said = run(InProcessLink(SoftBoard(robot), VirtualClock()), motion)
    places = [(m.x_m, m.y_m) for m in said if isinstance(m, PosePosition)]
    late = int(2 * period_s / TICK_S)  # before the ramp out
    ticks = int(4 * period_s / TICK_S)
    (x0, y0), (x1, y1) = places[-late - ticks], places[-late]
    assert math.hypot(x1 - x0, y1 - y0) / (ticks * TICK_S) == pytest.approx(0.137, rel=0.03)
    assert any(isinstance(m, PoseMotion) for m in said)


def test_encoders_follow_the_set_points_with_the_servos_lag() -> None:
    robot = load_robot("penn_state")
    motion = GaitMotion(Gait.from_degrees(40, 80, 3), 5, 10.0, 2.0)
    link = InProcessLink(SoftBoard(robot), VirtualClock())
    said = run(link, motion)
    states = [m for m in said if isinstance(m, State)]
    assert {state.mode for state in states} == {Mode.DISARMED, Mode.ARMED}
    lag_s = robot.servo.time_constant_s
    gain, delay_s = 1 / math.hypot(1, 3 * lag_s), math.atan(3 * lag_s) / 3
    for sample in samples(said, 5):
        t_s = sample.state.sequence * TICK_S
        if not 4 < t_s < 7:
            continue
        held_s = TICK_S / 2  # a set-point is held for a tick: half a tick of delay
        ideal = motion.angles(t_s - delay_s - held_s)
        for counts, angle in zip(sample.measured_counts, ideal, strict=True):
            assert counts is not None
            assert counts * robot.rad_per_count == pytest.approx(gain * angle, abs=0.004)


def test_a_free_joint_of_a_held_robot_still_measures() -> None:
    """Disarmed, the robot lies at rest where it was put."""
    start = [0.3, -0.2, 0.1, 0.0, 0.5]
    link = InProcessLink(SoftBoard(load_robot("penn_state"), start_rad=start), VirtualClock())
    said: list[Message] = []
    while link.clock.now_s() < 1.0:
        said += hear(link, 0.5)
    last = samples(said, 5)[-1]
    counts = [count for count in last.measured_counts if count is not None]
    assert [c * 2 * math.pi / 8192 for c in counts] == pytest.approx(start, abs=1e-3)


def test_clock_drift_effect_and_board_drift_add_up() -> None:
    robot = load_robot("penn_state")
    board = SoftBoard(robot, _effects(robot, "clock_drift:ppm=300"), drift_ppm=200.0)
    link = InProcessLink(board, VirtualClock())
    link.receive(0.0)
    link.clock.sleep_until(100.0)
    link.receive(0.0)
    say(link, Ping(1))
    (pong,) = [m for m in hear(link) if isinstance(m, Pong)]
    assert pong.board_time_us == pytest.approx(100e6 * (1 + 500e-6), abs=3)
