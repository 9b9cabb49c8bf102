"""Matching of motions: are two runs one motion, and where in time does one lie in the other?

In: times and signals of two runs. Out: a shift in time (``shift``), or the samples at which both were commanded the
same (``motion``). Used by the analysis (a run beside its simulation), by the marking of repeats, by the diagnosis
(which repeats tell the noise floor, which runs must not part between folds) and by its menu (what was run already).
"""
