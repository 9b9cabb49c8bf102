"""A bad line: answers that are lost or damaged are asked for again, counted, and never the end."""

from __future__ import annotations

import math

import pytest
from rigs import Rig, bench, emulated

from firmware_protocol.catalogue import Mode
from snakebot.servobus.master import TRIES
from snakebot.softboard.disturbance import BadPackets, Rates

both = pytest.mark.parametrize("model", ["sts3215", "xl330"])


def on_a_bad_line(model: str, rates: Rates, seed: int = 1) -> tuple[Rig, BadPackets, BadPackets]:
    """Found on a good line; from then on it is bad in both directions."""
    robot = bench()
    rig = Rig(emulated(model, robot=robot), robot)
    out = BadPackets(rates, seed, rig.clock.now_s)
    back = BadPackets(rates, seed + 1, rig.clock.now_s)
    rig.bus.to_servos, rig.bus.to_host = out, back
    return rig, out, back


def wave(rig: Rig, seconds: float, amplitude_rad: float = 0.4) -> float:
    """Stream a wave; the largest distance of a reading from the register, rad (lag included)."""
    start = rig.bench.arm()

    def target(t_s: float) -> list[float]:
        grown = min(t_s / 0.5, 1.0)
        return [a + grown * amplitude_rad * math.sin(4 * t_s + j) - grown * a for j, a in enumerate(start)]

    rig.bench.samples.clear()
    rig.bench.stream(seconds, target)
    rad = rig.bench.rad_per_count
    return max(
        abs(counts * rad - applied)
        for sample in rig.bench.samples
        for counts, applied in zip(sample.measured_counts, sample.applied_rad, strict=True)
        if counts is not None
    )


@both
@pytest.mark.parametrize(
    "rates",
    [
        pytest.param(Rates(flip=0.01), marks=pytest.mark.slow, id="damaged"),
        pytest.param(Rates(drop=0.05), marks=pytest.mark.slow, id="lost"),
        pytest.param(Rates(flip=0.01, drop=0.05), id="both"),
    ],
)
def test_a_run_goes_on_at_one_percent_damaged_and_five_percent_lost(model: str, rates: Rates) -> None:
    """Eight seconds of a moving snake on a line that is bad in both directions."""
    good, _, _ = on_a_bad_line(model, Rates())
    good.bench.fresh()
    usual = wave(good, 2.0)
    rig, out, _ = on_a_bad_line(model, rates)
    rig.bench.fresh()
    farthest = wave(rig, 8.0)
    assert rig.board.mode is Mode.ARMED
    assert out.done.dropped + out.done.flipped > 20
    statistics = rig.master.statistics
    assert statistics.retried > 50
    if rates.flip:
        assert statistics.corrupt > 20
    lost = sum(c is None for sample in rig.bench.samples for c in sample.measured_counts)
    assert lost < 0.04 * 5 * len(rig.bench.samples), "asking again finds nearly all of them"
    # some lost goals: the way of some ticks at 1.6 rad/s. On Feetech's a damaged goal may pass the servo's check of one
    # byte, once in 256: a tick later it is put right, and here no speed limit of a servo softens it
    assert farthest < usual + (0.12 if model == "xl330" else 1.0)


@both
def test_a_silent_line_is_a_fault_after_five_cycles(model: str) -> None:
    rig, _, back = on_a_bad_line(model, Rates())
    rig.bench.fresh()
    here = rig.bench.arm()
    rig.stream(0.1, here)
    back.rates = Rates(drop=1.0)
    rig.stream(0.03, here)
    modes = [rig.board.mode]
    rig.stream(0.05, here)
    modes.append(rig.board.mode)
    assert modes == [Mode.ARMED, Mode.FAULT], "three cycles are not five"


@both
def test_a_question_is_asked_again_within_the_tick_and_no_oftener(model: str) -> None:
    rig, _, back = on_a_bad_line(model, Rates())
    model_ = rig.plant.joints[0].model
    register = model_["present_position"]
    back.rates = Rates(drop=1.0)
    before = rig.bus.instructions
    assert rig.master.sync_read([1, 2, 3], register.address, register.size) == {}
    assert rig.bus.instructions == before + TRIES
    before = rig.bus.instructions
    now_s = rig.clock.now_s()
    assert rig.master.sync_read([1, 2, 3], register.address, register.size, until_s=now_s) == {}
    assert rig.bus.instructions == before + 1, "no time left"


def test_a_reading_that_cannot_be_is_asked_again() -> None:
    """Two damaged bytes pass Feetech's check once in 256: a joint that seems to have jumped is doubted."""
    rig, _, _ = on_a_bad_line("sts3215", Rates())
    rig.bench.fresh()
    here = rig.bench.arm()
    rig.stream(0.1, here)
    lies = 0

    def lie(packets: object) -> bytes:
        nonlocal lies
        said = b"".join(packets)  # type: ignore[arg-type]
        answer = rig.master.dialect.answer(3, 0, rig.servos[2].read(56, 2))
        if answer in said and not lies:
            lies += 1
            return said.replace(answer, rig.master.dialect.answer(3, 0, (3900).to_bytes(2, "little")))
        return said

    rig.bus.to_host = lie
    rig.bench.samples.clear()
    rig.stream(0.1, here)
    assert lies
    angles = [s.measured_counts[2] for s in rig.bench.samples if s.measured_counts[2] is not None]
    assert max(map(abs, angles)) <= 1


@pytest.mark.parametrize("second", ["heard", "lost"])
@pytest.mark.parametrize("part", ["torque off", "angle sensor"])
def test_one_bad_look_at_a_servo_is_no_fault(part: str, second: str) -> None:
    """It is asked once more before it is believed; where that answer is lost, the first is not taken for both."""
    rig, _, _ = on_a_bad_line("sts3215", Rates())
    rig.bench.fresh()
    here = rig.bench.arm()
    rig.stream(0.1, here)
    lies = 0

    def lie(packets: object) -> bytes:
        nonlocal lies
        block = rig.servos[1].read(40, 31)
        truth = rig.master.dialect.answer(2, 0, block)
        said = b"".join(packets)  # type: ignore[arg-type]
        if truth in said and not lies:
            lies += 1
            damaged = bytearray(block)
            damaged[0 if part == "torque off" else 65 - 40] = 0 if part == "torque off" else 1 << 1
            return said.replace(truth, rig.master.dialect.answer(2, 0, bytes(damaged)))
        if truth in said and lies == 1 and second == "lost":
            lies += 1
            return said.replace(truth, b"")
        return said

    rig.bus.to_host = lie
    rig.stream(0.3, here)
    assert lies == (2 if second == "lost" else 1)
    assert rig.board.mode is Mode.ARMED
