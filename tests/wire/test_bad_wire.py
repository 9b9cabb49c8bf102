"""Runs over a wire that flips, drops, doubles, delays, reorders and cuts, on a serial line and on CAN."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_bench import Bench

from firmware_protocol.catalogue import Mode
from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError, NoBoardError
from snakebot.robot import Robot, robot_from_mapping
from snakebot.softboard.disturbance import BadBus, BadStream, Rates

BAD = Rates(flip=0.01, drop=0.05)
AWFUL = Rates(flip=0.5, drop=0.5)
TE_RISE = 0.005  # of the gait's amplitude; over 20 seeds the worst is 0.003


def clean_error(**options: object) -> float:
    bench = Bench(duration_s=6, **options)  # type: ignore[arg-type]
    bench.run()
    return bench.tracking_error(2, 4)


@pytest.mark.parametrize("can", [False, True])
def test_one_percent_corrupt_and_five_percent_lost_the_run_goes_on(can: bool) -> None:
    clean = clean_error()
    for seed in range(2):
        bench = Bench(BAD, seed, can=can, duration_s=6)
        result = bench.run()
        assert result.ended == "finished"
        error = bench.tracking_error(2, 4)
        print(f"TE {clean:.4f} clean, {error:.4f} on the bad wire, {result.progress.lost} ticks unanswered")
        assert clean - TE_RISE < error < clean + TE_RISE
        assert result.progress.lost > 0.2 * result.progress.ticks, "the wire was not bad"


def many_joints(joints: int) -> Robot:
    limits = {"angle_deg": 95, "speed_rad_s": 8, "acceleration_rad_s2": 60}
    return robot_from_mapping({"joints": joints, "limits": limits}, "test")


@pytest.mark.parametrize(
    ("joints", "rate_hz"),
    [
        pytest.param(joints, rate_hz, marks=[] if rate_hz in (20, 151) else pytest.mark.slow)
        for joints in (5, 16)
        for rate_hz in (20, 25, 40, 50, 100, 151, 300)
    ],
)
def test_the_run_goes_on_at_any_rate_and_with_any_number_of_joints(joints: int, rate_hz: float) -> None:
    for seed, can in ((11, False), (12, True)):
        bench = Bench(BAD, seed, can=can, robot=many_joints(joints), rate_hz=rate_hz, duration_s=5)
        assert bench.run().ended == "finished"


@pytest.mark.parametrize("can", [False, True])
def test_half_of_everything_lost_ends_the_run_and_leaves_the_board_safe(can: bool) -> None:
    bench = Bench(Rates(delay_s=0.03, delay=1e-9), 3, can=can, duration_s=60)

    def worsen() -> None:
        if bench.clock.now_s() > 4:
            for disturbance in bench.disturbances:
                disturbance.rates = AWFUL

    bench.link.before = worsen
    with pytest.raises((LostBoardError, BoardFaultError)) as ended:
        bench.run()
    assert ended.value.exit_status in (4, 5)
    last_s = bench.joints.commands[-1][0]
    assert last_s < 4.2, "set-points still got through"
    bench.rest_of_life(0.1)
    assert bench.sim.mode is not Mode.ARMED
    bench.rest_of_life(2.1)
    assert not any(bench.joints.powered)
    assert bench.joints.commands[-1][0] < last_s + 0.2


def test_a_wire_that_is_awful_from_the_start_moves_nothing() -> None:
    bench = Bench(AWFUL, 1)
    with pytest.raises(NoBoardError, match="no board answered"):
        bench.run()
    assert not bench.joints.commands


def test_every_kind_of_disturbance_together() -> None:
    rates = Rates(0.002, drop=0.03, duplicate=0.05, delay=0.05, reorder=0.05, truncate=0.01, delay_s=0.03)
    bench = Bench(rates, 5, duration_s=6)
    assert bench.run().ended == "finished"
    done = bench.disturbances[0].done
    assert min(done.flipped, done.dropped, done.duplicated, done.delayed, done.reordered, done.truncated) > 3
    assert abs(bench.tracking_error(2, 4) - clean_error()) < 2 * TE_RISE


def test_the_same_seed_breaks_the_same_packets() -> None:
    """The host's tokens and nonces are random, so the wire is compared on bytes of ours."""
    sent = [pack_all([Frame(16, bytes([count % 250] * 8))]) for count in range(300)]
    wires = [BadStream(Rates(flip=0.05, drop=0.1, reorder=0.1), 7, lambda: 0.0) for _ in range(2)]
    first, second = ([wire(data) for data in sent] for wire in wires)
    assert first == second
    assert first != sent


@settings(max_examples=60, deadline=None)
@given(st.lists(st.binary(max_size=40), max_size=30))
def test_a_clean_wire_hands_on_every_byte(chunks: list[bytes]) -> None:
    wire = BadStream(Rates(), 0, lambda: 0.0)
    out = b"".join(map(wire, chunks)) + wire(b"\0")
    assert out == b"".join(chunks) + b"\0"


def test_late_packets_come_when_they_are_due() -> None:
    now = [0.0]
    wire = BadStream(Rates(delay=1.0, delay_s=0.5), 1, lambda: now[0])
    data = pack_all([Frame(16, b"12345678"), Frame(17, b"12345678")])
    assert wire(data) == b""
    assert wire.due_s is not None
    assert 0 <= wire.due_s <= 0.5
    now[0] = 0.5
    assert sorted(frame.id for frame in StreamDecoder().feed(wire(b""))) == [16, 17]
    assert wire.due_s is None


def test_can_controllers_refuse_damaged_frames_unless_told_otherwise() -> None:
    frames = [Frame(16, bytes(8))] * 200
    refused = BadBus(Rates(flip=0.1), 1, lambda: 0.0)(frames)
    assert set(refused) == {frames[0]}
    assert 40 < len(refused) < 120  # 0.9 ** 9 of 200 is 77
    damaged = BadBus(Rates(flip=0.1), 1, lambda: 0.0, checked=False)(frames)
    assert len(damaged) == 200
    assert any(frame.id != 16 for frame in damaged)


@pytest.mark.parametrize("bad", [{"flip": 1.1}, {"drop": -0.1}, {"delay": float("nan")}, {"delay_s": -1.0}])
def test_rates_that_are_none_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(BadInputError, match=next(iter(bad))):
        Rates(**bad)
