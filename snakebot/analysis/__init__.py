"""What a run says: tracking, sines, steady state, speed, power, link; one run, several runs, a run against
another."""
