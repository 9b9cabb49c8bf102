"""``snakebot completion``: the script that makes a shell complete commands and options."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from snakebot.errors import BadInputError


@click.command(
    name="completion",
    epilog="""\b
Examples:
  snakebot completion bash > ~/.local/share/bash-completion/completions/snakebot
  snakebot completion zsh > ~/.zfunc/_snakebot
  snakebot completion fish > ~/.config/fish/completions/snakebot.fish
""",
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    """Print the script that makes SHELL complete snakebot's commands and options."""
    from snakebot.cli.main import cli

    maker = get_completion_class(shell)
    if maker is None:
        raise BadInputError(f"no completion for {shell}")
    click.echo(maker(cli, {}, "snakebot", "_SNAKEBOT_COMPLETE").source())
