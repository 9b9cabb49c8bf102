"""Where the files that come with snakebot are: in the checkout, or inside an installed wheel."""

from __future__ import annotations

import contextlib
from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

DEFAULT_ROBOT = "penn_state"  # where a command is told of none
_PACKAGE = Path(__file__).resolve().parent


def configs_root() -> Path:
    """The folder that holds ``robots/``, ``effects/``, ``gaits/`` and ``motions/``."""
    installed = _PACKAGE / "configs"
    return installed if installed.is_dir() else _PACKAGE.parent / "configs"


def config_path(kind: str, source: str | Path) -> Path:
    """A file of the user's, or, by its bare name, one of ours in ``configs/<kind>/``.

    Raises:
        BadInputError: neither exists; the line lists the names that do.
    """
    given = Path(source)
    folder = configs_root() / kind
    ours = folder / f"{given.name.removesuffix('.yaml')}.yaml"
    bare = len(given.parts) == 1 or given.parts[:-1] == ("configs", kind)
    with contextlib.suppress(OSError):  # a name that is too long for a file
        if given.is_file():
            return given
        if bare and ours.is_file():
            return ours
    with contextlib.suppress(OSError):
        if given.is_dir():
            raise BadInputError(
                f"{source}: a folder; give a file, or one of the {kind} that come with snakebot"
            )
    known = sorted(path.stem for path in folder.glob("*.yaml"))
    hint = did_you_mean(given.name.removesuffix(".yaml"), known)
    raise BadInputError(
        f"{source}: no such file, nor one of the {kind} that come with snakebot ({', '.join(known)}){hint}"
    )
