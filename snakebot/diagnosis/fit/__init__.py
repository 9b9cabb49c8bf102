"""Fit: one explanation at a time, fitted to some runs and scored on others.

In: ``Evidence`` and a ``hypothesis.Hypothesis`` (which effects, on which joints, which parameters open). Out: a
``trial.Trial``: parameters, covariance, mean squares of the residuals block by block, fitted and held out.

* ``least_squares`` minimises the Cauchy loss of many small problems at once, within bounds.
* ``fit_runs`` makes the problems of one explanation: parameters of the body against the motion over ground, all others
  against the joint angles. ``fold_fits`` does it for each fold and leaves out an effect that a fold says nothing of.
* ``uncertainty``: standard errors from scatter, from the tolerance of the nominal numbers, from the model itself.
"""
