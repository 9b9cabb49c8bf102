"""``python -m snakebot``: the command line."""

from snakebot.cli.entry import main

main()
