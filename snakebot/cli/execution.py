"""One motion on one board, attended by a person: open, ask, log, show, run, close, report."""

from __future__ import annotations

import contextlib
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.ports import open_port
from snakebot.errors import BadInputError, SnakebotError

if TYPE_CHECKING:
    from snakebot.board import Board
    from snakebot.control import RunLoop, RunResult
    from snakebot.gait import Gait, Motion
    from snakebot.robot import Robot

_PANEL_S = 0.15  # between two pictures of the live panel


def execute(
    robot: Robot,
    gait: Gait | None,
    make_motion: Callable[[Sequence[float]], Motion],
    faults: Sequence[Any],
    options: dict[str, Any],
    *,
    title: str | None = None,
    amplitude_rad: float | None = None,
    about: Mapping[str, Any] | None = None,
) -> str:
    """Open, connect, run, close, report. Returns how the run ended.

    ``title`` and ``amplitude_rad`` stand for a motion that is no gait; ``about`` is added to the log's metadata.
    """
    from snakebot.board import Board, check_limits
    from snakebot.clock import MonotonicClock, VirtualClock
    from snakebot.control import RunLoop, registry
    from snakebot.control.loop import check_rate
    from snakebot.runlog.naming import gait_label, new_log_path

    check_rate(options["rate"])
    check_limits(robot)
    clock = VirtualClock() if options["fast"] else MonotonicClock()
    port = options["port"]
    simulated = robot
    if options.get("lifted"):
        from snakebot.lifted import lifted

        simulated = lifted(robot)
    link = open_port(port, clock, simulated, options["effects"], options["seed"], virtual=options["fast"])
    with contextlib.closing(link):
        board = Board(link, clock)
        info = board.connect()
        board.check_robot(robot)
        title = f"{gait}" if title is None else title
        _confirm(port, robot, title, info.simulated, options)
        path = options["log_path"] or new_log_path(gait_label(gait))
        start_ns = time.time_ns()
        writer = _writer(path, robot, gait, board, options, start_ns, about or {})
        loop = RunLoop(
            board,
            robot,
            make_motion,
            rate_hz=options["rate"],
            clock=clock,
            amplitude_rad=gait.alpha_rad if gait is not None else amplitude_rad or math.nan,
            settle_s=options["ramp"],
            faults=faults,
            recorder=writer,
            log_frames=options["frames"],
            start_time_ns=start_ns,
            keep_stop=options["keep_stop"],
        )
        result: RunResult | None = None
        try:
            with registry.registered(port), _signals(loop), _panel(loop, gait, title, robot, options):
                result = loop.run()
        except SnakebotError as error:
            writer.add_metadata({"ended": f"error: {error}"})
            raise
        finally:
            with contextlib.suppress(SnakebotError) if sys.exc_info()[0] else contextlib.nullcontext():
                if result is not None:
                    writer.add_metadata({"ended": result.ended})
                writer.close()
            if result is None and writer.path.exists():
                click.echo(f"log up to there: {writer.path}", err=True)
    from snakebot.cli.summary import report

    report(result, writer.path, as_json=options["as_json"])
    return result.ended


def _confirm(port: str, robot: Robot, title: str, simulated: bool, options: dict[str, Any]) -> None:
    if simulated or options["yes"]:
        return
    if not sys.stdin.isatty():
        raise BadInputError(f"{port} is a real robot, and there is nobody to ask: add --yes if it may move")
    click.confirm(
        f"{port}: a real robot ({robot.joints} joints) will move now: {title}. Is everyone clear of it?",
        abort=True,
    )


def _writer(
    path: Path,
    robot: Robot,
    gait: Gait | None,
    board: Board,
    options: dict[str, Any],
    start_ns: int,
    about: Mapping[str, Any],
) -> Any:
    import platform
    from dataclasses import asdict

    from firmware_protocol.catalogue import catalogue_hash, dbc_text
    from snakebot import __version__
    from snakebot.runlog import RunWriter
    from snakebot.runlog.log import gait_to_mapping

    assert board.info is not None
    metadata = {
        "gait": gait_to_mapping(gait) if gait is not None else None,
        "ramp_s": options["ramp"],
        "rate_hz": options["rate"],
        "port": options["port"],
        "faults": list(options["faults"]),
        "effects": list(options["effects"]),
        "seed": options["seed"],
        "simulated": board.info.simulated,
        "virtual_time": options["fast"],
        "forward_speed_m_s": options["speed"],
        "notes": options["note"],
        "board": asdict(board.info),
        "catalogue_hash": f"{catalogue_hash():08x}",
        "snakebot_version": __version__,
        "python_version": platform.python_version(),
        "platform": platform.platform(),
        **about,
    }
    return RunWriter(
        path,
        robot,
        {key: value for key, value in metadata.items() if value is not None},
        attachments={"snakebot.dbc": dbc_text().encode()},
        start_time_ns=start_ns,
    )


@contextlib.contextmanager
def _signals(loop: RunLoop) -> Iterator[None]:
    """Ctrl-C, SIGTERM and a closed terminal ramp down; the stop signal cuts the power."""
    from snakebot.control.registry import STOP_SIGNAL

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers = {
        number: lambda *_: loop.request_stop() for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    handlers[STOP_SIGNAL] = lambda *_: loop.request_emergency_stop()
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def _panel(
    loop: RunLoop, gait: Gait | None, title: str, robot: Robot, options: dict[str, Any]
) -> Iterator[None]:
    """The live panel, drawn by a thread of its own, and its keys; nothing where nobody looks."""
    if options["as_json"] or options["fast"] or not sys.stdout.isatty():
        yield
        return
    from rich.live import Live

    from snakebot.cli import keys
    from snakebot.cli.panel import panel

    done = threading.Event()
    shown = [title]
    before = sys.getswitchinterval()
    sys.setswitchinterval(2e-4)  # drawing takes milliseconds: the loop must get in between
    with contextlib.ExitStack() as stack:
        live = stack.enter_context(Live(auto_refresh=False, transient=True))
        if gait is not None:
            stack.enter_context(keys.listening(loop, gait, lambda wanted: shown.append(str(wanted))))
        foot = (
            f"{options['port']}   {keys.HELP}" if gait is not None and sys.stdin.isatty() else options["port"]
        )

        def draw() -> None:
            while not done.wait(_PANEL_S):
                live.update(panel(loop.progress, shown[-1], foot, robot.angle_limit_rad), refresh=True)

        thread = threading.Thread(target=draw, name="panel", daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join(timeout=2.0)
            sys.setswitchinterval(before)
