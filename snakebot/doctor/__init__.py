"""What is wrong with this computer, a port, a board or a bus of servos: findings, each with advice. Nothing moves."""
