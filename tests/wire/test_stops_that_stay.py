"""A stop that somebody else makes is never undone by a host's own way of ending: neither late, nor lost, nor deaf."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from wire_bench import Bench

from firmware_protocol.catalogue import EmergencyStop, Fault, Message, Mode, ModeRequest, decode, encode
from firmware_protocol.framing import unpack
from snakebot.board import Reading
from snakebot.errors import BoardFaultError, LostBoardError, SnakebotError

OTHER = 0xBEEF


def stop(bench: Bench) -> None:
    """Somebody else stops the board, now."""
    bench.sim.receive(encode(EmergencyStop(host=OTHER)), bench.clock.now_s())


def at_the_first(bench: Bench, mode: Mode, act: Callable[[bytes], bytes]) -> None:
    """``act`` decides what becomes of the first request for a mode on its way to the board."""
    waiting = [True]

    def through(data: bytes) -> bytes:
        out = b""
        for packet in filter(None, data.split(b"\0")):
            message: Message = decode(unpack(packet))
            is_it = isinstance(message, ModeRequest) and message.mode is mode
            if is_it and waiting:
                waiting.clear()
                out += act(packet + b"\0")
            else:
                out += packet + b"\0"
        return out

    bench.link._to_board = through


def stays_stopped(bench: Bench) -> None:
    """The board is stopped, says so, and a run that keeps stops does not move it."""
    bench.rest_of_life(0.3)
    assert bench.sim.mode is Mode.STOPPED
    assert bench.sim._machine.fault is Fault.EMERGENCY_STOP
    assert not any(bench.joints.powered)
    before = len(bench.joints.power_changes)
    with pytest.raises(BoardFaultError, match="stopped already: nothing was moved"):
        Bench(on=bench, seed=7, keep_stop=True, duration_s=2).run()
    assert bench.sim.mode is Mode.STOPPED
    assert len(bench.joints.power_changes) == before


def run_ends_with(bench: Bench, error: type[SnakebotError]) -> SnakebotError:
    with pytest.raises(error) as caught:
        bench.run()
    return caught.value


def test_a_host_that_has_gone_deaf_does_not_clear_a_stop() -> None:
    bench = Bench(duration_s=20)
    bench.link._to_host = lambda data: b"" if bench.clock.now_s() > 3 else data
    stopped: list[int] = []

    def before() -> None:
        if bench.clock.now_s() > 3.2 and not stopped:
            stop(bench)
            stopped.append(bench.sim._machine.latch)

    bench.link.before = before
    run_ends_with(bench, LostBoardError)
    assert stopped
    stays_stopped(bench)


def test_a_disarm_that_was_lost_and_is_repeated_does_not_clear_a_stop() -> None:
    bench = Bench(duration_s=3)

    def lose(packet: bytes) -> bytes:
        stop(bench)
        return b""

    at_the_first(bench, Mode.DISARMED, lose)
    assert run_ends_with(bench, BoardFaultError).exit_status == 5
    stays_stopped(bench)


def test_a_stop_just_before_the_disarm_stays_and_is_told() -> None:
    bench = Bench(duration_s=3)

    def overtake(packet: bytes) -> bytes:
        stop(bench)
        return packet

    at_the_first(bench, Mode.DISARMED, overtake)
    error = run_ends_with(bench, BoardFaultError)
    assert error.exit_status == 5
    assert "emergency stop" in str(error)
    assert any(event.kind == "fault" for event in bench.memory.events)
    stays_stopped(bench)


@pytest.mark.parametrize("mode", [Mode.HOLDING, Mode.DISARMED])
def test_a_stop_while_the_run_ends_is_told_though_its_fault_event_is_lost(mode: Mode) -> None:
    bench = Bench(duration_s=3)
    deaf: list[float] = []

    def to_host(data: bytes) -> bytes:
        """No FaultEvent is heard."""
        packets = filter(None, data.split(b"\0"))
        return b"".join(packet + b"\0" for packet in packets if unpack(packet).id != 2)

    def overtake(packet: bytes) -> bytes:
        stop(bench)
        deaf.append(bench.clock.now_s())
        return packet

    at_the_first(bench, mode, overtake)
    bench.link._to_host = to_host
    assert run_ends_with(bench, BoardFaultError).exit_status == 5
    assert deaf
    bench.rest_of_life(0.3)
    assert bench.sim.mode is Mode.STOPPED


def test_a_stop_after_connecting_is_not_cleared_by_the_run_that_begins_now() -> None:
    """Whoever has just stopped the robot does not see it start because somebody else had asked for a run before."""
    bench = Bench(duration_s=3)
    stop(bench)
    bench.board.connect()
    bench.clock.sleep_until(bench.clock.now_s() + 5)  # a person is asked whether everyone is clear
    stop(bench)
    with pytest.raises(BoardFaultError, match="just before the run began: nothing was moved"):
        bench.loop.run()
    stays_stopped(bench)


def test_a_stop_that_overtakes_the_clear_stays() -> None:
    bench = Bench(duration_s=3)
    stop(bench)
    bench.board.connect()
    clear = bench.board.clear

    def late() -> None:
        stop(bench)
        clear()

    bench.board.clear = late  # type: ignore[method-assign]
    with pytest.raises(BoardFaultError, match="stopped again meanwhile"):
        bench.loop.run()
    stays_stopped(bench)


def test_a_clear_that_is_doubled_on_the_wire_does_not_clear_a_later_stop() -> None:
    bench = Bench(duration_s=3)
    stop(bench)
    bench.board.connect()
    kept: list[bytes] = []

    def keep(data: bytes) -> bytes:
        kept.append(data)
        return data

    bench.link._to_board = keep
    bench.loop.run()
    clear = [p for data in kept for p in data.split(b"\0") if p and unpack(p).id == 69]
    assert len(clear) == 1
    stop(bench)
    for packet in clear:
        bench.sim.receive(unpack(packet), bench.clock.now_s())
    stays_stopped(bench)


def test_a_run_that_is_refused_lets_another_hosts_run_be() -> None:
    ours = Bench(duration_s=6)
    tried: list[str] = []

    def second() -> None:
        if ours.clock.now_s() > 3 and not tried:
            tried.append("")
            other = Bench(on=ours, seed=9, duration_s=2)
            other.board.mode, other.board.info = Mode.ARMED, ours.board.info
            other.loop._meet_watchdog()
            for mode in (Mode.ARMED, Mode.HOLDING, Mode.DISARMED):
                ours.sim.receive(encode(ModeRequest(1, mode, other.board.host)), ours.clock.now_s())
            other.board.info = ours.board.info
            other.loop._meet_watchdog()
            other.loop._ends.give_up(lost=True)
            other.loop._ends.give_up()

    ours.link.before = second
    assert ours.run().ended == "finished"
    assert tried
    assert ours.sim.mode is Mode.DISARMED


def test_what_a_request_reads_while_it_waits_is_handed_out() -> None:
    bench = Bench(duration_s=3)
    bench.board.connect()
    bench.board.poll()
    bench.board.arm()
    for _ in range(3):
        bench.clock.sleep_until(bench.clock.now_s() + 0.01)
        bench.board.send_setpoints([0.0] * 5, 0.01)
        bench.board.hold()
        bench.board.arm()
    items = bench.board.heard()
    assert len([item for item in items if isinstance(item, Reading)]) >= 3
    assert bench.board.heard() == []
