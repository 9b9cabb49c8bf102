"""Proposal: the next experiment.

In: ``Evidence`` and explanations that it cannot tell apart. Out: an ``experiment.Proposal``: a motion with the
command to run it, or the signal that would settle what no motion does.

* ``motions``: what ``configs/motions/menu.yaml`` has. ``menu``: those of them that keep the robot's limits.
  ``separation``: how far one of them would tell two explanations apart, given what is open of their parameters.
  ``experiment`` picks.
"""
