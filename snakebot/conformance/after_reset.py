"""What a board says first after a reset, and of a joint that it knows nothing of."""

from __future__ import annotations

from firmware_protocol.catalogue import BoardHeartbeat, Counters, Mode, Result, State, TrimRequest
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.violations import NotApplicableError, expect

_AT_ONCE_US = 5_000  # a main loop that looks every few milliseconds


@case(
    "The first heartbeat and the first sample come at once at a reset, the first Counters 1 s later.",
    needs=("reset_at",),
)
def speaks_at_once_after_a_reset(bench: Bench) -> None:
    assert bench.lab.reset_at is not None
    for start_us in (0, 123_456_789):
        bench.begin()
        bench.lab.reset_at(start_us)
        reset_s = bench.clock.now_s()
        firsts: dict[type, float] = {}
        states = []
        while bench.clock.now_s() < reset_s + 1.2:
            for message in bench.listen(0.001):
                firsts.setdefault(type(message), bench.clock.now_s() - reset_s)
                if isinstance(message, State):
                    states.append(message)
        for kind, wanted_s in ((BoardHeartbeat, 0.0), (State, 0.0), (Counters, 1.0)):
            expect(kind in firsts, f"no {kind.__name__} within 1.2 s after a reset")
            late_s = firsts[kind] - wanted_s
            expect(
                abs(late_s) <= 1e-6 * _AT_ONCE_US + 2 * bench.tolerance_s,
                f"the first {kind.__name__} came {firsts[kind]:.4f} s after a reset, not {wanted_s:g} s",
            )
        first = states[0]
        shown = passed_us(first.board_time_us, start_us)
        expect(
            shown <= _AT_ONCE_US,
            f"the clock stood at {start_us} us at a reset, the first sample says {first}",
        )
        seen = (first.sequence, first.sample, first.mode)
        expect(seen == (0, 0, Mode.DISARMED), f"the first sample after a reset is {first}")


@case(
    "A joint whose encoder has given no angle since the reset is told as standing at 0, whatever its trim.",
    needs=("reset", "lose_encoder"),
)
def unread_joints_stand_at_nought(bench: Bench) -> None:
    lose = bench.lab.lose_encoder
    assert lose is not None
    assert bench.reset is not None
    if not bench.simulated:
        raise NotApplicableError("a trim cannot be read back: on a real robot it is left alone")

    def trim(joint: int, trim_rad: float) -> None:
        answer = bench.ask(TrimRequest(bench.token(), joint, trim_rad, bench.host))
        expect(answer.result is Result.OK, f"a trim of {trim_rad} rad was answered {answer}")

    for joint in range(1, bench.joints + 1):
        trim(joint, 0.1 if joint % 2 else -0.1)
        lose(joint, True)
        try:
            bench.start_anew()
            applied = bench.sample().applied_rad[joint - 1]
            expect(abs(applied) < 1e-9, f"joint {joint} was never read, and is told as applied {applied} rad")
        finally:
            lose(joint, False)
            trim(joint, 0.0)
            bench.reset()
            bench.identify()
