"""How urgently a run has been asked to end."""

from __future__ import annotations


class StopRequests:
    """Requests from signal handlers and other threads, counted by kind.

    ``urgency`` is 0: go on, 1: ramp down, hold and relax, 2: hold and relax at once.
    """

    def __init__(self) -> None:
        self.urgency = 0
        self._interrupts = 0

    def request(self) -> None:
        """Ask for the end. A hangup comes from the terminal and from the shell: however often, it is one request."""
        self.urgency = max(self.urgency, 1)

    def interrupt(self) -> None:
        """A person presses Ctrl-C; the second time, more urgently.

        Raises:
            KeyboardInterrupt: the third time.
        """
        self._interrupts += 1
        if self._interrupts > 2:
            raise KeyboardInterrupt
        self.urgency = max(self.urgency, self._interrupts)
