"""Evidence: what was recorded, what the nominal robot would have shown of it, and how much of the difference is noise.

In: a session (``runlog.Session``). Out: one frozen record, ``gather.Evidence``, that no later room changes.

* ``sanity`` refuses what cannot be diagnosed; ``data`` cleans the runs: spikes, holes, servo-off stretches, motions.
  ``turns`` makes readings run on that jump by a whole turn.
  ``ticks`` and ``slow_logs`` put set-points between the rows of a log that is slower than they came.
* ``simulator`` predicts the recorded runs under any effects (``effects.prediction.joint_run``); ``predictor`` adds the
  motion over ground and what no effect changes.
* ``usual``: what the servos bear and how fast the joints turn.
* ``repeats`` and ``floor``: the noise floor, from runs of one motion (``runlog.matching``). A robot that changed
  between two of them is not noise.
* ``tolerance``: what the nominal numbers may be off by, in shares that ``within_bounds`` finds. ``angles`` and
  ``ground_evidence`` hold what was measured with the spread that noise and tolerance allow it.
* ``blocks``, ``score``, ``gap``: residuals are compared in blocks of a second by a Cauchy loss; a gap is a residual
  above the allowed spread.
* ``folds``: which runs are fitted and which are only predicted. Runs of one motion are never on both sides.
"""
