"""Frames out, frames in, and patience: what has passed between a host and a board that it knows nothing of."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any, TypeVar

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import Sample, SampleAssembler
from firmware_protocol.catalogue import Message, decode, encode, frame_id
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.clock import Clock, VirtualClock
from snakebot.conformance.violations import ViolationError, expect
from snakebot.links.base import Link

M = TypeVar("M", bound=Message)

PATIENCE_S = 1.0  # for an answer that must come at once
_RETRY_S = 0.25  # for an answer, before the request is sent again; chosen
_NAP_S = 0.002  # longest wait in one go: a longer gap between two looks at the clock is our own stall
_TRAFFIC_KEPT = 30  # frames told with a case that failed; chosen, a screen


class Exchange:
    """Messages with the board at the end of a link.

    Attributes:
        heard: messages since the case began.
        samples: complete ones since the case began, once the number of joints is known.
        unreadable: frames that were no message of the catalogue.
        sent: frames, since the exchange began.
    """

    def __init__(self, link: Link, clock: Clock) -> None:
        self.link = link
        self.clock = clock
        self.heard: list[Message] = []
        self.samples: list[Sample] = []
        self.unreadable = 0
        self.sent = 0
        self._assembler: SampleAssembler | None = None
        self._token = 0
        self._stalled_s = 0.0
        self._looked_s = clock.now_s()
        self._traffic: deque[tuple[float, str, Frame]] = deque(maxlen=_TRAFFIC_KEPT)
        self._longest_nap_s = math.inf if isinstance(clock, VirtualClock) else _NAP_S

    def begin(self) -> None:
        """A case begins: what was heard before is forgotten."""
        self._hear(self.clock.now_s())
        self.heard.clear()
        self.samples.clear()
        self._stalled_s, self._looked_s = 0.0, self.clock.now_s()

    def sample_joints(self, joints: int) -> None:
        """From now on samples of so many joints are put together."""
        if self._assembler is None or self._assembler.joints != joints:
            self._assembler = SampleAssembler(joints)

    def send_frames(self, frames: Sequence[Frame]) -> None:
        now_s = self.clock.now_s()
        self._traffic.extend((now_s, ">", frame) for frame in frames)
        self.link.send(frames)
        self.sent += len(frames)

    def send(self, *messages: Message) -> None:
        self.send_frames([encode(message) for message in messages])

    def traffic(self) -> list[str]:
        """The last frames both ways, decoded."""
        return [f"{t_s:.4f} {way} {frame}  {_shown(frame)}" for t_s, way, frame in self._traffic]

    def stalled_s(self) -> float:
        """The longest time in which this computer did not look, since the case began."""
        return self._stalled_s

    def _hear(self, until_s: float) -> list[Message]:
        """One look at the link."""
        before_s = self.clock.now_s()
        nap_s = max(min(until_s - before_s, self._longest_nap_s), 0.0)
        frames = self.link.receive(nap_s)
        now_s = self.clock.now_s()
        self._stalled_s = max(self._stalled_s, before_s - self._looked_s, now_s - before_s - nap_s)
        self._looked_s = now_s
        said = []
        for frame in frames:
            self._traffic.append((now_s, "<", frame))
            try:
                message = decode(frame)
            except ProtocolError as error:
                self.unreadable += 1
                raise ViolationError(f"the board sent what is no message of the catalogue: {error}") from None
            said.append(message)
            if isinstance(message, msg.State | msg.Measured | msg.Applied) and self._assembler is not None:
                sample = self._assembler.add(message)
                if sample is not None:
                    self.samples.append(sample)
        self.heard += said
        return said

    def listen(self, for_s: float) -> list[Message]:
        """All that the board says in that time."""
        until_s = self.clock.now_s() + for_s
        said = self._hear(until_s)
        while self.clock.now_s() < until_s:
            said += self._hear(until_s)
        return said

    def wait(self, kind: type[M], timeout_s: float = PATIENCE_S, **values: object) -> M:
        """The next message of a kind with these values.

        Raises:
            ViolationError: it did not come in time.
        """
        until_s = self.clock.now_s() + timeout_s
        while True:
            found: M | None = None
            for message in self._hear(until_s):
                right = all(getattr(message, name, None) == value for name, value in values.items())
                if found is None and isinstance(message, kind) and right:
                    found = message
            if found is not None:
                return found
            if self.clock.now_s() >= until_s:
                wanted = ", ".join(f"{name}={value!r}" for name, value in values.items())
                raise ViolationError(f"no {kind.__name__}({wanted}) within {timeout_s:g} s")

    def ask(self, request: Any) -> msg.Acknowledge:
        """A request's acknowledgement, repeated as a host would.

        Raises:
            ViolationError: none came for this host, or one that names another request.
        """
        for attempt in range(4):
            self.send(request)
            try:
                answer = self.wait(msg.Acknowledge, _RETRY_S, token=request.token, host=request.host)
            except ViolationError:
                if attempt == 3:
                    raise ViolationError(
                        f"{type(request).__name__} was not acknowledged in 4 tries"
                    ) from None
                continue
            expect(
                answer.request == frame_id(type(request)),
                f"an Acknowledge must name the request's identifier, {frame_id(type(request))}, not {answer.request}",
            )
            return answer
        raise AssertionError("not reached")

    def token(self) -> int:
        self._token = (self._token + 1) % 256
        return self._token


def _shown(frame: Frame) -> str:
    try:
        return str(decode(frame))
    except ProtocolError:
        return "no message of the catalogue"
