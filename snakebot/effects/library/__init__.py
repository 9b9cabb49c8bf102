"""The effects that come with snakebot, one a file."""
