"""The page of ``diagnose --live``: it stays over all runs, and shows the verdict as it forms."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from snakebot.errors import BoardFaultError

if TYPE_CHECKING:
    from snakebot.cli.run_options import RunOptions
    from snakebot.diagnosis import Diagnosis
    from snakebot.robot import Robot
    from snakebot.view.feed import Feed

_SHOWN_SHARE = 0.01  # of a diagnosis between two words of how far it is


class Story:
    """What an undertaking of several runs tells its page; without a page, nothing.

    Attributes:
        page: what a run is given as click's ``obj`` to be shown there.
    """

    def __init__(self, page: Feed | None) -> None:
        self.page = page
        self._runs: list[dict[str, str]] = []
        self._shown_share = 0.0

    def begins(self, what: str) -> None:
        """A run begins."""
        self._tell(now=f"{what} is going on")

    def ran(self, command: str, how: str) -> None:
        """A run is over, and its log is whole."""
        self._runs.append({"command": command, "how": how})
        self._tell(now="between two runs", runs=self._runs)

    def diagnosing(self, text: str, share: float) -> None:
        """How far the diagnosis of the runs so far is."""
        if abs(share - self._shown_share) >= _SHOWN_SHARE:
            self._shown_share = share
            self._tell(now=f"diagnosing {len(self._runs)} runs: {100 * share:.0f} % {text}")

    def verdict(self, found: Diagnosis) -> Diagnosis:
        """The runs so far have been diagnosed."""
        if self.page is None:
            return found
        from snakebot.diagnosis.show.named import cause_lines, cause_name, joint_count
        from snakebot.diagnosis.show.words import headline

        causes = [
            {
                "name": cause_name(c, joint_count(found)),
                "probability": c.probability,
                "parameters": cause_lines(c),
            }
            for c in found.causes
        ]
        proposal = found.next_experiment
        then = "" if proposal is None else f"next: {proposal.command} ({proposal.reason})"
        self._tell(now=f"after {len(self._runs)} runs", verdict=headline(found), causes=causes, next=then)
        return found

    def check(self, port: str) -> None:
        """Go on only if no page has asked for an end.

        Raises:
            BoardFaultError: STOP was pressed, in a run or between two.
            KeyboardInterrupt: "Ramp down" was.
        """
        asked = self.page.ends if self.page is not None else ()
        if "stop" in asked:
            raise BoardFaultError(f"{port}: emergency stop: no further run is made")
        if "ramp_down" in asked:
            raise KeyboardInterrupt

    def _tell(self, **story: Any) -> None:
        if self.page is not None:
            self.page.tell(**story)


@contextlib.contextmanager
def live_story(robot: Robot, options: RunOptions) -> Iterator[Story]:
    """Open the page, where it is wanted, for as long as the whole undertaking lasts.

    Raises:
        BadInputError: as ``open_page``.
    """
    from snakebot.cli.live_page import open_page
    from snakebot.view.feed import about_run

    about = about_run(robot, "diagnose --live", port=options.port)
    page = open_page(about, options, several=True, between_runs=_end)
    story = Story(page)
    how = ""
    try:
        yield story
        how = "the verdict stands"
    except BaseException as error:
        how = str(error) or type(error).__name__
        raise
    finally:
        if page is not None:
            page.end(how)
            page.close()


def _end(what: str) -> None:
    """End the wait between two runs, or the diagnosis, as `snakebot stop` and Ctrl-C do."""
    from snakebot.control import registry

    number = registry.STOP_SIGNAL if what == "stop" else signal.SIGINT
    if callable(signal.getsignal(number)):  # and in any case ``Story.check`` knows it
        os.kill(os.getpid(), number)
