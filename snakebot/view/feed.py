"""The run's end of the live page: records go out without ever waiting, wishes of the pages come in."""

from __future__ import annotations

import contextlib
import math
import queue
import secrets
import select
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from snakebot.errors import BadInputError, SnakebotError
from snakebot.view import DEFAULT_PORT, LOOPBACK
from snakebot.view.messages import STATUS, pack, unpack

if TYPE_CHECKING:
    from snakebot.control import RunLoop
    from snakebot.gait import Gait
    from snakebot.robot import Robot

_STATUS_S = 0.2  # between two reports of what the log does not hold: mode, progress, gait
_BUFFER_BYTES = 1 << 20  # of the socket to the server: some seconds of records, then they are left out
_STARTS_S = 30.0  # the longest that the server may take to say where it listens
_LARGEST = 1 << 16  # bytes of a packet from the server
_ENDS_S = 1.0  # the longest that the server may take to end; then it is killed
_SWITCH_S = 2e-4  # of Python's threads: a wish of a page, or a gait's check, does not hold up a tick
ENDS = ("stop", "ramp_down")  # wishes that end a motion
_DIGITS = 6  # of a gait's numbers: 30 degrees are shown as 30, not as what radians make of them


@dataclass(frozen=True)
class ViewSettings:
    """Where the page is served.

    Attributes:
        address: a name or number of this computer; other than loopback, a token in the page's address is required.
        port: 0 takes a free one.
        stop_on_close: ramp down when the last page has gone.
    """

    address: str = LOOPBACK
    port: int = DEFAULT_PORT
    stop_on_close: bool = False


class Feed:
    """The connection to the process that serves the page: of one run, or of several one after the other.

    A thread of it takes what the pages ask for, as long as it is open. A stop is obeyed at once, and if no run is going
    on, by the next one: nothing that a page asked for is lost between two runs.

    Args:
        about: what the page is told first: robot, title, limits.
        several: an undertaking of several runs, each of which calls ``begin``.
        between_runs: called when a page wants to "stop" or "ramp_down" while no run is going on.

    Raises:
        BadInputError: the page cannot be served there.
    """

    def __init__(
        self,
        settings: ViewSettings,
        about: Mapping[str, Any],
        *,
        several: bool = False,
        between_runs: Callable[[str], None] = lambda what: None,
    ) -> None:
        self.left_out = 0  # records that the server was too slow for
        self.several = several
        self.ends: set[str] = set()  # "stop", "ramp_down": asked for by a page since the page was opened
        self._between_runs = between_runs
        self._loop: RunLoop | None = None
        self._changing = threading.Lock()  # of the two above
        self._wishes: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER_BYTES)
        with theirs:
            words = [sys.executable, "-m", "snakebot.view.server", str(theirs.fileno())]
            self._server = subprocess.Popen(
                words, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, start_new_session=True
            )
        self.url: str = self._start(settings, about)
        self._threads = [
            threading.Thread(target=work, name=name, daemon=True)
            for name, work in (("view", self._attend), ("view wishes", self._work))
        ]
        for thread in self._threads:
            thread.start()

    def _start(self, settings: ViewSettings, about: Mapping[str, Any]) -> str:
        wanted = {
            "address": settings.address,
            "port": settings.port,
            "stop_on_close": settings.stop_on_close,
            "token": secrets.token_urlsafe(12),
            "about": dict(about),
        }
        self._socket.settimeout(_STARTS_S)
        try:
            self._socket.send(pack(STATUS, 0, wanted))
            answer = unpack(self._socket.recv(_LARGEST)).values()
        except (OSError, ValueError) as error:
            self._end_server()
            raise BadInputError(f"--view: the page's server did not start: {error}") from None
        if "error" in answer:
            self._end_server()
            raise BadInputError(f"--view: {answer['error']}")
        self._socket.setblocking(
            False
        )  # with a time limit of Python's own, a send to a full socket would wait for it
        return str(answer["url"])

    # -- to the pages ------------------------------------------------------------------------------------------------

    def tap(self, channel_id: int, log_time_ns: int, data: bytes) -> None:
        """Hand on one record of the log. Never waits, never raises."""
        try:
            self._socket.send(pack(channel_id, log_time_ns, data))
        except OSError:
            self.left_out += 1

    def begin(self, about: Mapping[str, Any]) -> None:
        """Another run of the same undertaking: its pages stay open."""
        self._say({"begin": dict(about)})

    def tell(self, **story: Any) -> None:
        """Tell the pages of an undertaking what has become of it so far."""
        self._say({"story": story})

    def end(self, how: str) -> None:
        """Tell the pages of an undertaking that it is over, and how."""
        self._say({"ended": True, "how": how})

    def _report(self, loop: RunLoop, **more: Any) -> None:
        progress, mode = loop.progress, loop.board.mode
        gait = loop.gait if progress.ticks else None  # before, the motion is none yet
        self._say(
            {
                "t_s": progress.t_s,
                "duration_s": progress.duration_s,
                "mode": mode.name.lower() if mode is not None else None,
                "fault": loop.board.fault.name.lower(),
                "note": progress.note,
                "clamped": progress.clamped,
                "gait": None if gait is None else _in_degrees(gait),
                **more,
            }
        )

    def _say(self, values: Mapping[str, Any]) -> None:
        with contextlib.suppress(OSError):
            self._socket.send(pack(STATUS, 0, values))

    # -- from the pages ----------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def serving(self, loop: RunLoop, log: Path) -> Iterator[None]:
        """Do what the pages ask for to this run, as long as it lasts."""
        self._say({"log": str(log)})
        switch_s = sys.getswitchinterval()
        sys.setswitchinterval(_SWITCH_S)
        with self._changing:
            self._loop = loop
            asked = set(self.ends)
        for what in asked:
            obey(loop, {"do": what})
        how = ""
        try:
            yield
        except BaseException as error:
            how = str(error) or type(error).__name__
            raise
        finally:
            with self._changing:
                self._loop = None
            sys.setswitchinterval(switch_s)
            self._report(loop, **({} if self.several else {"ended": True, "how": how or loop.progress.note}))

    def _attend(self) -> None:
        """Take what the pages ask for. What ends a motion is done here and now; the rest may take its time."""
        while True:
            ready, _, _ = select.select([self._socket], [], [], _STATUS_S)
            if ready:
                try:
                    wish = unpack(self._socket.recv(_LARGEST)).values()
                except (OSError, ValueError):
                    break  # the server has gone, or we are closed: the run goes on without a page
                if wish.get("do") in ENDS:
                    self._end_motion(wish)
                else:
                    self._wishes.put(wish)
            with self._changing:
                loop = self._loop
                if loop is not None:  # told before another run begins
                    self._report(loop)
        self._wishes.put(None)

    def _end_motion(self, wish: Mapping[str, Any]) -> None:
        with self._changing:
            self.ends.add(wish["do"])
            loop = self._loop
            if loop is not None:
                obey(loop, wish)
        if loop is None:
            self._between_runs(wish["do"])
        self._answer(wish, None)

    def _work(self) -> None:
        while (wish := self._wishes.get()) is not None:
            with self._changing:
                loop = self._loop
            self._answer(wish, obey(loop, wish) if loop is not None else "no run is going on")

    def _answer(self, wish: Mapping[str, Any], refused: str | None) -> None:
        self._say({"reply": {"id": wish.get("id"), "refused": refused}})

    # -- the end -----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Nothing more comes: the pages are told, and their server ends."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # the thread that waits for it wakes
        for thread in self._threads:
            thread.join(timeout=_ENDS_S)
        self._end_server()

    def _end_server(self) -> None:
        self._socket.close()
        try:
            self._server.wait(timeout=_ENDS_S)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait()


def _in_degrees(gait: Gait) -> dict[str, float]:
    return {
        "alpha_deg": round(math.degrees(gait.alpha_rad), _DIGITS),
        "beta_deg": round(math.degrees(gait.beta_rad), _DIGITS),
        "omega_rad_s": round(gait.omega_rad_s, _DIGITS),
        "offset_deg": round(math.degrees(gait.offset_rad), _DIGITS),
    }


def obey(loop: RunLoop, wish: Mapping[str, Any]) -> str | None:
    """Do what a page asks for. Returns why it was refused, or None."""
    from snakebot.control import parse_fault
    from snakebot.gait import Gait

    try:
        match wish.get("do"):
            case "stop":
                loop.request_emergency_stop()
            case "ramp_down":
                loop.request_stop()
            case "gait":
                names = ("alpha_deg", "beta_deg", "omega_rad_s", "offset_deg")
                loop.change_gait(Gait.from_degrees(*(float(wish[name]) for name in names)))
            case "fault":
                loop.request_fault(parse_fault(str(wish["fault"]), loop.robot.joints))
            case _:
                return "not understood"
    except SnakebotError as error:
        return str(error)
    except (KeyError, TypeError, ValueError):
        return "not understood"
    return None


def about_run(robot: Robot, title: str, *, port: str) -> dict[str, Any]:
    """What a page is told first of a run."""
    return {
        "title": title,
        "port": port,
        "robot": robot.name,
        "joints": robot.joints,
        "half_length_m": robot.body.half_length_m if robot.body is not None else None,
        "angle_limit_deg": [math.degrees(value) for value in robot.angle_limit_rad],
        "speed_limit_rad_s": list(robot.speed_limit_rad_s),
        "acceleration_limit_rad_s2": list(robot.acceleration_limit_rad_s2),
    }
