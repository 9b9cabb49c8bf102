"""snakebot: drive, simulate and diagnose a servo snake robot."""

__version__ = "0.1.0"
