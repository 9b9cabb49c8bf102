"""What the board says of itself and its joints: samples, beats, identity, clock."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from board_rig import HOST, M, Rig, bench, samples

from firmware_protocol.catalogue import (
    BoardHeartbeat,
    Counters,
    InfoFirmware,
    InfoProtocol,
    InfoRequest,
    InfoSerial,
    JointMode,
    JointModeRequest,
    Message,
    Mode,
    Ping,
    Pong,
    PoseMotion,
    PosePosition,
    State,
    catalogue_hash,
)
from snakebot.errors import BadInputError
from snakebot.softboard import SoftBoard


def kinds(said: list[Message], kind: type[M]) -> list[M]:
    return [message for message in said if isinstance(message, kind)]


def test_sample_number_wraps_at_12_bits() -> None:
    rig = Rig()
    numbers = [sample.state.sample for sample in samples(rig.advance(410.0), 5)]
    assert numbers[:3] == [1, 2, 3]
    assert all((b - a) % 4096 == 1 for a, b in itertools.pairwise(numbers))
    assert numbers[-1] < 10


def test_arming_starts_from_the_measured_angles() -> None:
    rig = Rig()
    rig.plant.angle_rad = [0.3, -0.2, 0.0, 1.0, 2.5]  # the last one outside its limit
    rig.go(Mode.ARMED)
    assert rig.plant.commands[-1][1] == pytest.approx(rig.plant.angle_rad, abs=4e-4)
    assert set(rig.plant.modes) == {"active"}
    rig.advance(0.01)
    (sample,) = samples(rig.tick([0.3, -0.2, 0.0, 1.0, 2.5]), 5)
    assert sample.applied_rad == pytest.approx([0.3, -0.2, 0.0, 1.0, 2.5], abs=0.01), "nothing jumps"


def test_a_joint_that_has_never_been_read_gets_no_power() -> None:
    rig = Rig()
    rig.plant.lost = {1}
    rig.plant.angle_rad = [0.1, 0.9, 0.1, 0.1, 0.1]
    rig.board.reset(rig.now_s)
    rig.go(Mode.ARMED)
    assert rig.plant.modes == ["active", "free", "active", "active", "active"]
    rig.stream(0.1)
    assert rig.plant.modes[1] == "free"
    assert rig.plant.angle_rad[1] == 0.9
    rig.plant.lost = set()
    rig.stream(0.1)
    rig.say(JointModeRequest(2, 2, JointMode.ACTIVE, 0.0, HOST))
    assert rig.plant.modes[1] == "active"
    assert rig.plant.commands[-1][1][1] == pytest.approx(0.9, abs=4e-4), "it starts where it is"


def test_applied_angle_beyond_the_wire_is_reported_at_its_edge() -> None:
    rig = Rig(bench(1))
    rig.plant.angle_rad = [-7.0]
    assert samples(rig.advance(0.1), 1)[-1].applied_rad[0] == pytest.approx(-3.2767)


def test_pose_follows_its_sample_and_is_left_out_beyond_the_wire() -> None:
    rig = Rig()
    assert not kinds(rig.advance(0.1), PosePosition)
    rig.plant.place = (1.5, -2.25, 0.125, 0.137)
    said = rig.advance(0.1)
    (position,), (motion,) = kinds(said, PosePosition), kinds(said, PoseMotion)
    assert position.sample == motion.sample == kinds(said, State)[0].sample
    assert (position.x_m, position.y_m) == pytest.approx((1.5, -2.25))
    assert (motion.heading_rad, motion.speed_m_s) == pytest.approx((0.125, 0.137))
    rig.plant.place = (900.0, 0.0, 0.0, 0.0)
    said = rig.advance(0.1)
    assert samples(said, 5)
    assert not kinds(said, PosePosition) + kinds(said, PoseMotion)


def test_identity() -> None:
    rig = Rig(bench(7, encoder_counts_per_rev=4096), serial_number=0xDEADBEEFCAFE)
    said = rig.say(InfoRequest(1))
    protocol = rig.one(said, InfoProtocol)
    assert (protocol.protocol_major, protocol.joints, protocol.simulated) == (2, 7, 1)
    assert protocol.catalogue_hash == catalogue_hash()
    firmware = rig.one(said, InfoFirmware)
    assert (firmware.watchdog_ms, firmware.counts_per_rev) == (100, 4096)
    assert firmware.boot_id == rig.board.boot_id
    assert rig.one(said, InfoSerial).serial_number == 0xDEADBEEFCAFE


def test_reset_draws_a_new_boot_id_disarms_and_restarts_the_counters() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(1.0)
    seen = set()
    for _ in range(50):
        before = rig.board.boot_id
        rig.board.reset(rig.now_s)
        assert rig.board.boot_id != before
        seen.add(rig.board.boot_id)
    assert len(seen) > 40
    assert rig.mode() is Mode.DISARMED
    assert set(rig.plant.modes) == {"free"}
    said = rig.advance(1.0)
    assert kinds(said, BoardHeartbeat)[-1].boot_id == rig.board.boot_id
    assert rig.one(said, Counters).received == 0
    assert kinds(said, State)[-1].sequence == 0


def test_boot_ids_come_from_the_system_unless_seeded() -> None:
    def boots(seed: int | None) -> set[int]:
        ids = set()
        for _ in range(8):
            board = SoftBoard(bench(1), plant=Rig(bench(1)).plant, boot_seed=seed)
            board.advance(1.0)
            ids.add(board.boot_id)
        return ids

    assert len(boots(3)) == 1
    assert len(boots(None)) > 4


@pytest.mark.parametrize("drift_ppm", [-200.0, 0.0, 35.0, 5000.0])
def test_own_clock_has_offset_and_drift(drift_ppm: float) -> None:
    rig = Rig(clock_offset_us=123_456, drift_ppm=drift_ppm)
    for _ in range(5):
        rig.advance(7.7)
        shown = rig.one(rig.say(Ping(1)), Pong).board_time_us
        assert shown == pytest.approx(123_456 + rig.now_s * 1e6 * (1 + drift_ppm * 1e-6), abs=2)


def test_board_time_wraps_at_32_bits() -> None:
    rig = Rig(clock_offset_us=(1 << 32) - 1_500_000)
    times = [state.board_time_us for state in kinds(rig.advance(3.0), State)]
    assert max(times) > (1 << 32) - 200_000
    assert min(times) < 200_000
    assert all((b - a) % (1 << 32) == pytest.approx(100_000, abs=2) for a, b in itertools.pairwise(times))


def test_timers_run_on_the_boards_own_clock() -> None:
    rig = Rig(drift_ppm=100_000.0)  # a tenth too fast
    rig.go(Mode.ARMED)
    rig.advance(0.0908)
    assert rig.mode() is Mode.ARMED
    rig.advance(0.0002)
    assert rig.mode() is Mode.FAULT


def test_advancing_to_the_next_event_always_moves_on() -> None:
    for offset_s in (0.0, 1e3, 123456.789, 3e7):
        for drift_ppm in (-123.4, 0.0, 77.7):
            board = SoftBoard(bench(1), plant=Rig(bench(1)).plant, drift_ppm=drift_ppm)
            board.advance(offset_s)
            for _ in range(500):
                before = board.next_event_s
                assert board.advance(before)
                assert board.next_event_s > before


def test_time_that_goes_back_is_taken_as_standing() -> None:
    rig = Rig()
    rig.advance(5.0)
    assert rig.board.advance(1.0) == []
    assert rig.one(rig.say(Ping(1)), Pong).board_time_us == 5_000_000


@pytest.mark.parametrize(
    ("robot", "word"),
    [({"joints": 17}, "16"), ({"joints": 1, "encoder_counts_per_rev": 65536}, "65535")],
)
def test_robots_that_the_protocol_cannot_carry_are_refused(robot: dict[str, Any], word: str) -> None:
    with pytest.raises(BadInputError, match=word):
        SoftBoard(bench(**robot))


@pytest.mark.parametrize(
    "wrong",
    [
        {"drift_ppm": math.nan},
        {"drift_ppm": -1e6},
        {"serial_number": -1},
        {"serial_number": 1 << 64},
        {"start_rad": [0.0] * 4},
        {"watchdog_ms": 19},
        {"watchdog_ms": 256},
    ],
)
def test_values_that_no_board_has_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(BadInputError):
        SoftBoard(bench(), **wrong)


def test_counters_wrap_at_16_bits() -> None:
    rig = Rig()
    rig.board.note_corrupt(65536 + 7)
    assert rig.one(rig.advance(1.0), Counters).corrupt == 7
    assert math.isfinite(rig.board.next_event_s)
