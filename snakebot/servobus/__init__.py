"""Servos that share one serial bus: Feetech STS and SCS, Dynamixel X.

Packets (``feetech``, ``dynamixel``), one register table a model (``models``), the host's end of the bus (``master``),
the joints that a board in software drives through it (``plant``), and servos that are not there (``emulated``).
"""
