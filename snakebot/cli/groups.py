"""Groups of commands."""

from __future__ import annotations

import click

from snakebot.nearest import did_you_mean


class Group(click.Group):
    """A group that says which command a misspelt one may have been, and imports none to find out."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        known = self.list_commands(ctx)
        if name not in known and not name.startswith("-") and not ctx.resilient_parsing:
            raise click.UsageError(f"No such command {name!r}{did_you_mean(name, known) or '.'}", ctx)
        return super().resolve_command(ctx, args)
