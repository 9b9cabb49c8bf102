"""The best gait of a calibrated robot: chosen on its simulation, promised with an interval."""
