"""The live page: a browser shows the robot as it moves, changes its gait, and stops it.

Two processes, so that a page can never hold up a tick:

* In the run's own process, ``feed`` copies each record of the log into a socket that never blocks (what does not fit
  is left out), and one small thread takes what the pages ask for: stop, ramp down, another gait, a joint fault.
* In a process of its own, ``server`` keeps the picture of the last 30 s (``picture``), serves the page's files
  (``files``) and talks to each page over a web socket (``pages``) or, to other viewers, in Foxglove's protocol
  (``foxglove``). Each page is sent the newest state as fast as it takes it, at most ``FRAMES_PER_S``.

``recording`` plays a log into the same server.
"""

from __future__ import annotations

DEFAULT_PORT = 8040  # TCP; chosen, free on most computers
LOOPBACK = "127.0.0.1"
