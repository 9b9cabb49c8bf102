"""``snakebot jog``: move one joint by keys."""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from snakebot.cli import names
from snakebot.cli.robot_option import robot_option
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunLoop
    from snakebot.gait.jog import JogMotion

RATE_HZ = 50.0  # of set-points; chosen: smooth to the eye, slow enough for any line
_KEY_S = 0.2  # between keys that come from a pipe
_HELP = "+/- or arrows: turn   1-9: joint   space: emergency stop   q: end"
_ARROWS = {"\x1b[C": "+", "\x1b[A": "+", "\x1b[D": "-", "\x1b[B": "-"}


@click.command(
    name="jog",
    epilog="""\b
Examples:
  snakebot jog feetech:/dev/ttyUSB0 --joint 3
  snakebot jog serial:/dev/ttyUSB0 --joint 1 --step 0.5
  printf '+++q' | snakebot jog sim: --joint 2

\b
Only this joint moves, the others hold where they are or have no power; the limits of the description are kept.
""",
)
@click.argument("port", shell_complete=names.ports, default="sim:")
@click.option(
    "--joint",
    shell_complete=names.joints,
    type=click.IntRange(min=1),
    required=True,
    help="Which one, from 1 at the tail.",
)
@click.option("--step", "step_deg", type=float, default=2.0, show_default=True, help="Of one key, deg.")
@click.option("--others-free", is_flag=True, help="The other joints get no power [they hold where they are].")
@robot_option()
@click.option("--no-servo-watchdog", is_flag=True, help="As in `snakebot run`.")
@click.option("--yes", is_flag=True, help="Do not ask before a real robot moves.")
def command(
    port: str,
    joint: int,
    step_deg: float,
    others_free: bool,
    robot_source: str,
    no_servo_watchdog: bool,
    yes: bool,
) -> None:
    """Turn one joint by keys, in small steps."""
    from snakebot.cli.attendance import signals_ramp_down, tell
    from snakebot.cli.execution import confirm
    from snakebot.cli.ports import patience
    from snakebot.control import RunLoop, open_board, parse_fault, registry
    from snakebot.control.attending import Attendant
    from snakebot.gait.jog import JogMotion
    from snakebot.robot import load_robot

    robot = load_robot(robot_source)
    if joint > robot.joints:
        raise BadInputError(f"--joint {joint}: robot {robot.name!r} has joints 1 to {robot.joints}")
    if not 0 < step_deg <= 10:
        raise BadInputError(f"--step {step_deg:g}: give more than 0 and at most 10 deg")
    others = "+".join(str(number) for number in range(1, robot.joints + 1) if number != joint)
    faults = [parse_fault(f"free:{others}", robot.joints)] if others_free and others else []
    motions: list[JogMotion] = []

    def make_motion(start_rad: Sequence[float]) -> JogMotion:
        motions.append(JogMotion(start_rad, robot.angle_limit_rad))
        return motions[-1]

    with contextlib.ExitStack() as stack:
        with patience(port):
            board = stack.enter_context(
                open_board(port, robot, rate_hz=RATE_HZ, servo_watchdog=not no_servo_watchdog, tell=tell)
            )
        assert board.info is not None
        if not (board.info.simulated or yes):
            confirm(port, robot, f"joint {joint}")
        loop = RunLoop(
            board,
            robot,
            make_motion,
            rate_hz=RATE_HZ,
            clock=board.clock,
            amplitude_rad=math.nan,
            faults=faults,
        )
        click.echo(_HELP, err=True)
        stack.enter_context(signals_ramp_down(loop))
        stack.enter_context(Attendant(port).until_logged(loop))
        stack.enter_context(registry.registered(port))
        stack.enter_context(_keys(loop, motions, joint, math.radians(step_deg)))
        loop.run()
    if motions:
        shown = " ".join(f"{math.degrees(angle):.1f}" for angle in motions[-1].target_rad)
        click.echo(f"joints sent to {shown} deg; relaxed")


class _Hand:
    """Which joint the keys turn, and what each key does."""

    def __init__(self, loop: RunLoop, motions: Sequence[JogMotion], joint: int, step_rad: float) -> None:
        self._loop = loop
        self._motions = motions
        self._joint = joint
        self._step_rad = step_rad

    def press(self, key: str) -> bool:
        """Obey a key; False: it ends the motion."""
        if key == "q":
            self._loop.request_stop()
            return False
        if key == " ":
            self._loop.request_emergency_stop()
            return False
        motion = self._motions[-1]
        if key in "123456789" and int(key) <= motion.joints:
            self._joint = int(key)
        elif key in "+=-":
            sign = -1 if key == "-" else 1
            try:
                motion.step(self._joint, self._loop.progress.t_s, sign * self._step_rad)
            except BadInputError as error:
                click.echo(f"\r{error}", err=True)
                return True
        else:
            return True
        target = math.degrees(motion.target_rad[self._joint - 1])
        click.echo(f"\rjoint {self._joint}: {target:6.1f} deg  ", nl=False, err=True)
        return True


@contextlib.contextmanager
def _keys(loop: RunLoop, motions: Sequence[JogMotion], joint: int, step_rad: float) -> Iterator[None]:
    """Listen to the keyboard, or to a pipe, key by key, while the joint is moved. The end of a pipe ends it."""
    hand = _Hand(loop, motions, joint, step_rad)
    source = sys.stdin.fileno()
    terminal = sys.stdin.isatty()
    done = threading.Event()

    def listen() -> None:
        while not loop.progress.ticks and not done.wait(0.02):  # the motion is checked before it begins
            pass
        while not done.is_set():
            if not select.select([source], [], [], 0.1)[0]:
                continue
            text = os.read(source, 16 if terminal else 1).decode(errors="replace")
            if not text:
                hand.press("q")
                return
            for key in [_ARROWS[text]] if text in _ARROWS else text:
                if not hand.press(key):
                    return
            if not terminal:
                done.wait(_KEY_S)

    thread = threading.Thread(target=listen, name="keys", daemon=True)
    with contextlib.ExitStack() as stack:
        if terminal:
            import termios
            import tty

            before = termios.tcgetattr(source)
            stack.callback(termios.tcsetattr, source, termios.TCSADRAIN, before)
            tty.setcbreak(source)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join(timeout=1.0)
            click.echo("", err=True)
