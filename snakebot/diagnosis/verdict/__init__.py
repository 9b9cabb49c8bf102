"""Verdict: what is said of the search's result.

In: ``Evidence`` and ``SearchResult``. Out: a ``conclude.Conclusion``, a diagnosis but for the next experiment.

* ``decision`` decides the verdict, in one place; ``rest`` measures what is left over; ``noise`` finds encoders that
  scatter.
* ``causes``: effects with parameters, ties and probabilities (``probability``, calibrated).
* ``closure``: how far the gap shrinks on held-out runs. ``localise`` and ``regime``: where it lies and when it is
  largest. ``traces``: a few stretches for pictures.
"""
