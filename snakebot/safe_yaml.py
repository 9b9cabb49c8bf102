"""YAML from a stranger: plain data only, of bounded size, with no way to blow up through aliases.

Only what JSON knows too is understood: mappings, lists, text, numbers, true and false, null. Dates and numbers to the
base of 60 (``12:30``), which YAML 1.1 guesses from plain text, stay text; other tags (``!!binary``, ``!!python/...``)
are refused. ``1e-3`` is a number, as in YAML 1.2 and everywhere else.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, ClassVar

import yaml
from yaml.constructor import ConstructorError
from yaml.error import MarkedYAMLError

from snakebot.errors import BadInputError

MAX_BYTES = 4 << 20  # chosen: a description has some kB
MAX_NODES = 200_000  # with aliases written out
MAX_DEPTH = 50  # of nesting; chosen: a description has less than ten levels
INTEGERS = 1 << 63  # larger ones are nobody's number, and no array's

_TAG = "tag:yaml.org,2002:"
_SCALARS = tuple(_TAG + kind for kind in ("null", "bool", "int", "float"))
_KNOWN = (*_SCALARS, *(_TAG + kind for kind in ("str", "seq", "map", "merge")), None)
_FLOAT = _TAG + "float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+\Z"), list("-+0123456789")
_Safe: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where it is built in: ten times faster


class _PlainLoader(_Safe):  # type: ignore[misc]
    """PyYAML's safe loader without the types that a robot has no use for."""

    yaml_implicit_resolvers: ClassVar = {
        first: [(tag, form) for tag, form in forms if tag in _KNOWN]
        for first, forms in _Safe.yaml_implicit_resolvers.items()
    }
    yaml_constructors: ClassVar = {
        tag: construct for tag, construct in _Safe.yaml_constructors.items() if tag in _KNOWN
    }

    def construct_number_or_truth(self, node: yaml.ScalarNode) -> Any:
        """The value of a scalar whose tag may have been written before any text."""
        if ":" in str(node.value):
            return node.value
        try:
            value = _Safe.yaml_constructors[node.tag](self, node)
            if isinstance(value, int) and not -INTEGERS <= value < INTEGERS:
                raise OverflowError
            return value
        except (ArithmeticError, LookupError, ValueError):
            why = f"{str(node.value)[:40]!r} is no {node.tag.removeprefix(_TAG)}"
            raise ConstructorError(None, None, why, node.start_mark) from None


for _tag in _SCALARS:
    _PlainLoader.add_constructor(_tag, _PlainLoader.construct_number_or_truth)
_PlainLoader.add_implicit_resolver(*_FLOAT)


class _PlainDumper(yaml.SafeDumper):
    """Writes what ``_PlainLoader`` reads back as it was: text that looks like a number gets quotes."""


_PlainDumper.add_implicit_resolver(*_FLOAT)


def dump_yaml(data: Any) -> str:
    """Plain data as YAML, keys in their order."""
    return str(yaml.dump(data, Dumper=_PlainDumper, sort_keys=False, allow_unicode=True))


def load_yaml(data: bytes | str, where: str) -> Any:
    """Parse one document.

    Raises:
        BadInputError: one line that names ``where``: too large, not UTF-8, not YAML, not plain data.
    """
    if len(data) > MAX_BYTES:
        raise BadInputError(f"{where}: larger than {MAX_BYTES >> 20} MiB; not read")
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data
        _check_size(text, where)
        loader = _PlainLoader(text)
        try:
            node = loader.get_single_node()
            if node is None:
                return None
            nodes, characters = _written_out(node, {}, 0)
            if nodes > MAX_NODES or characters > MAX_BYTES:
                raise BadInputError(
                    f"{where}: its aliases (*name) stand for more than {MAX_NODES} values or "
                    f"{MAX_BYTES >> 20} MiB; not read"
                )
            _check_keys(node, where, set())
            return loader.construct_document(node)
        finally:
            loader.dispose()
    except UnicodeError:
        raise BadInputError(f"{where}: not UTF-8 text") from None
    except (yaml.YAMLError, ValueError) as error:
        raise BadInputError(f"{where}: {_told(error)}") from None
    except RecursionError:
        raise BadInputError(f"{where}: nested too deep; not read") from None


def _told(error: Exception) -> str:
    """What is wrong with a text that is no YAML, and on which line."""
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        return f"not YAML: {' '.join(str(error).split())}".replace('in "<unicode string>"', "in its text")
    context = f"{error.context}, " if error.context else ""
    return f"line {error.problem_mark.line + 1}: not YAML: {context}{error.problem}"


@dataclass(frozen=True)
class Lines:
    """On which line of a document its keys stand: looked for only when an error is told.

    ``above`` leads to the part that is spoken of. The document is one that ``load_yaml`` has read; without a text no
    line is known.
    """

    text: bytes | str = b""
    above: tuple[str | int, ...] = ()

    def under(self, *keys: str | int) -> Lines:
        return Lines(self.text, (*self.above, *keys))

    def of(self, *keys: object) -> str:
        """``line 4: `` to go before a message, or nothing; of a key that is not there, where its mapping stands."""
        if not self.text:
            return ""
        text = self.text.decode("utf-8-sig") if isinstance(self.text, bytes) else self.text
        node, line = yaml.compose(text, Loader=_PlainLoader), 0
        for key in (*self.above, *keys):
            found = _below(node, key)
            if found is None:
                break
            line, node = found
        return f"line {line}: " if line else ""


NO_LINES = Lines()


def _below(node: Any, key: object) -> tuple[int, Any] | None:
    """Line, from 1, and value of a mapping's key or of a list's item."""
    if isinstance(node, yaml.MappingNode):
        for name, value in reversed(node.value):
            if isinstance(name, yaml.ScalarNode) and name.value == str(key):
                return name.start_mark.line + 1, value
    elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key].start_mark.line + 1, node.value[key]
    return None


def _check_size(text: str, where: str) -> None:
    """Stop at the first thing that is too much, before any of it is built: time and memory grow with what is there."""
    depth = nodes = 0
    for event in yaml.parse(text, Loader=_PlainLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        nodes += isinstance(event, yaml.NodeEvent)
        if depth > MAX_DEPTH:
            raise RecursionError
        if nodes > MAX_NODES:
            raise BadInputError(f"{where}: holds more than {MAX_NODES} values; not read")


def _check_keys(node: Any, where: str, seen: set[int]) -> None:
    """
    Raises:
        BadInputError: a mapping has a key twice; PyYAML would take the last one without a word.
    """
    if id(node) in seen:  # through an alias
        return
    seen.add(id(node))
    if isinstance(node, yaml.MappingNode):
        lines: dict[str, int] = {}
        for name, value in node.value:
            line = name.start_mark.line + 1
            if isinstance(name, yaml.ScalarNode) and name.tag != f"{_TAG}merge":
                key = str(name.value)
                if key in lines:
                    told = f"{where}: line {line}: {key} is given twice, before on line {lines[key]}"
                    raise BadInputError(told)
                lines[key] = line
            _check_keys(value, where, seen)
    elif isinstance(node, yaml.SequenceNode):
        for value in node.value:
            _check_keys(value, where, seen)


def _written_out(node: Any, sizes: dict[int, tuple[int, int]], depth: int) -> tuple[int, int]:
    """Number of nodes and of characters below ``node`` when each alias is replaced by what it stands for."""
    if depth > MAX_DEPTH:
        raise RecursionError
    known = sizes.get(id(node))
    if known is not None:
        return known
    nodes, characters, children = 1, 0, []
    if isinstance(node, yaml.MappingNode):
        children = [child for pair in node.value for child in pair]
    elif isinstance(node, yaml.SequenceNode):
        children = node.value
    else:
        characters = len(node.value)
    for child in children:
        below = _written_out(child, sizes, depth + 1)
        nodes, characters = nodes + below[0], characters + below[1]
    sizes[id(node)] = nodes, characters
    return nodes, characters
