"""The paper's experiments: sweeps over gaits, faults, friction, speed, and how far the paper is reproduced."""
