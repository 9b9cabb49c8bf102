"""YAML from a stranger: plain data only, of bounded size, with no way to blow up through aliases."""

from __future__ import annotations

from typing import Any

import yaml

from snakebot.errors import BadInputError

MAX_BYTES = 4 << 20
MAX_NODES = 200_000  # with aliases written out
MAX_DEPTH = 50


def load_yaml(data: bytes | str, where: str) -> Any:
    """Parse one document.

    Raises:
        BadInputError: one line that names ``where``: too large, not UTF-8, not YAML, not plain data.
    """
    if len(data) > MAX_BYTES:
        raise BadInputError(f"{where}: larger than {MAX_BYTES >> 20} MiB; not read")
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data
        _check_depth(text)
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        if node is None:
            return None
        if _written_out(node, {}, 0) > MAX_NODES:
            raise BadInputError(
                f"{where}: its aliases (*name) stand for more than {MAX_NODES} values; not read"
            )
        return yaml.safe_load(text)
    except UnicodeDecodeError:
        raise BadInputError(f"{where}: not UTF-8 text") from None
    except (yaml.YAMLError, ValueError) as error:
        raise BadInputError(f"{where}: not YAML: {' '.join(str(error).split())}") from None
    except RecursionError:
        raise BadInputError(f"{where}: nested too deep; not read") from None


def _check_depth(text: str) -> None:
    """Stop at the first thing nested too deep: the parser's time grows with the square of the depth."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            raise RecursionError


def _written_out(node: Any, sizes: dict[int, int], depth: int) -> int:
    """Number of nodes below ``node`` when each alias is replaced by what it stands for."""
    if depth > MAX_DEPTH:
        raise RecursionError
    known = sizes.get(id(node))
    if known is not None:
        return known
    if isinstance(node, yaml.MappingNode):
        children = [child for pair in node.value for child in pair]
    else:
        children = node.value if isinstance(node, yaml.SequenceNode) else []
    sizes[id(node)] = 1 + sum(_written_out(child, sizes, depth + 1) for child in children)
    return sizes[id(node)]
