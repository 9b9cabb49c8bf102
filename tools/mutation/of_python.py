"""Mutants of a Python file, made on its syntax tree (ast)."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from mutation.mutant import Change, other_numbers

_COMPARISONS: dict[type[ast.cmpop], tuple[str, ...]] = {
    ast.Lt: ("<=", ">="), ast.LtE: ("<", ">"), ast.Gt: (">=", "<="), ast.GtE: (">", "<"), ast.Eq: ("!=",),
    ast.NotEq: ("==",), ast.Is: ("is not",), ast.IsNot: ("is",), ast.In: ("not in",), ast.NotIn: ("in",),
}  # fmt: skip
_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.LShift: ">>", ast.RShift: "<<", ast.BitAnd: "|",
    ast.BitOr: "&", ast.FloorDiv: "*", ast.Mod: "*", ast.Pow: "*",
}  # fmt: skip
_TWINS = {"min": "max", "max": "min", "any": "all", "all": "any"}
# Names of one kind: each stands in for the one before.
_FAMILIES = {
    "Mode": ("DISARMED", "ARMED", "HOLDING", "STOPPED", "FAULT"),
    "JointMode": ("ACTIVE", "FREE", "RIGID", "RIGID_HERE"),
    "Result": ("OK", "BAD_VALUE", "BAD_JOINT", "FORBIDDEN", "HELD"),
    "Fault": ("NONE", "WATCHDOG", "EMERGENCY_STOP"),
    "LimitKind": ("ANGLE", "SPEED", "ACCELERATION"),
}

# Attributes and variables of one kind: what a slip of the pen writes for one another.
_SIBLINGS = (
    ("_beat_due_s", "_sample_due_s", "_counters_due_s"),
    ("_received", "_corrupt"),
    ("_refused", "clamped"),
    ("_fed_s", "fault_since_s"),
    ("angle_rad", "speed_rad_s", "acceleration_rad_s2"),
    ("_watchdog_s", "fault_since_s"),
    ("BEAT_S", "COUNTERS_S"),
    ("HOLD_PATIENCE_S", "RELAX_S"),
    ("_applied", "_target"),
    ("slow", "fast"),
    ("_trim_rad", "_zero_counts"),
    ("_free", "_known"),
    ("_watchdog_ms", "boot_id"),
    ("serial_number", "boot_id"),
    ("built_in", "limit"),
    ("declared", "credit"),
    ("measured", "applied"),
    ("near", "other"),
    ("angle", "speed", "acceleration"),
    ("low", "high"),
    ("dt", "dt_before"),
    ("target", "target_before"),
    ("received", "corrupt", "dropped", "clamped"),
    ("joints", "counts"),
    ("sequence", "sample"),
    ("x_m", "y_m", "heading_rad", "speed_m_s"),
)
_SIBLING = {name: family[(i + 1) % len(family)] for family in _SIBLINGS for i, name in enumerate(family)}


def _bound_names(text: bytes) -> list[tuple[int, int, set[str]]]:
    """Of each function its first and last line, its arguments and its variables."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef) and node.end_lineno is not None:
            names = {inner.arg for inner in ast.walk(node) if isinstance(inner, ast.arg)}
            names |= {
                n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
            }
            found.append((node.lineno, node.end_lineno, names))
    return found


class _File:
    def __init__(self, text: bytes) -> None:
        self.text = text
        self._bound = _bound_names(text)
        self._starts = [0]
        for line in text.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def place(self, line: int, column: int) -> int:
        return self._starts[line - 1] + column

    def span(self, node: ast.expr | ast.stmt | ast.keyword) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.place(node.lineno, node.col_offset), self.place(node.end_lineno, node.end_col_offset)

    def binds(self, name: str | None, line: int) -> bool:
        """That variable is one of the function that this line is in."""
        return any(first <= line <= last and name in names for first, last, names in self._bound)

    def has(self, name: str) -> bool:
        """That name stands somewhere in this file."""
        return re.search(rf"(?<![\w.]){re.escape(name)}\b", self.text.decode()) is not None

    def said(self, node: ast.expr | ast.stmt) -> str:
        first, last = self.span(node)
        return self.text[first:last].decode()

    def put(self, operator: str, node: ast.expr | ast.stmt, instead: str) -> Change:
        return operator, *self.span(node), instead

    def between(self, operator: str, left: ast.expr, right: ast.expr, was: str, instead: str) -> Change:
        """An operator between two operands: parentheses may stand there too."""
        first, last = self.span(left)[1], self.span(right)[0]
        gap = self.text[first:last].decode()
        assert gap.count(was) == 1, (gap, was)
        return operator, first, last, gap.replace(was, instead)


def changes(text: bytes, only: Sequence[str] = ()) -> Iterator[Change]:
    """All changes of one file; of its top level only what is named, where names are given."""
    file = _File(text)
    for node in ast.parse(text).body:
        named = getattr(node, "name", None)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            named = node.targets[0].id
        if not only or named in only:
            yield from _walk(file, node)


def _children(node: ast.AST) -> Iterator[ast.AST]:
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        yield from (
            item for item in (value if isinstance(value, list) else [value]) if isinstance(item, ast.AST)
        )


def _walk(file: _File, node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.If) and any(isinstance(inner, ast.Raise) for inner in node.body):
        return  # a caller's mistake, told by an exception: no conduct of a board
    if isinstance(node, ast.Assert | ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr | ast.Match):
        if isinstance(node, ast.Match):
            for inner in node.cases:
                for statement in inner.body:
                    yield from _walk(file, statement)
        return
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return  # a docstring
    if isinstance(node, ast.keyword) and node.arg == "strict":
        return
    yield from _of(file, node)
    for child in _children(node):
        yield from _walk(file, child)


def _of(file: _File, node: ast.AST) -> Iterator[Change]:
    match node:
        case ast.Compare():
            yield from _compare(file, node)
        case ast.BoolOp():
            was, instead = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield file.between("logic", left, right, was, instead)
            for value in node.values:
                yield file.put("condition", node, f"({file.said(value)})")
        case ast.BinOp() if type(node.op) in _ARITHMETIC:
            was = _sign(node.op)
            yield file.between("arithmetic", node.left, node.right, was, _ARITHMETIC[type(node.op)])
        case ast.AugAssign() if type(node.op) in _ARITHMETIC:
            was, instead = f"{_sign(node.op)}=", f"{_ARITHMETIC[type(node.op)]}="
            yield file.between("arithmetic", node.target, node.value, was, instead)
            yield file.put("removal", node, "pass")
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            operator = "condition" if isinstance(node.op, ast.Not) else "arithmetic"
            yield file.put(operator, node, f"({file.said(node.operand)})")
        case ast.If() | ast.While():
            yield file.put("condition", node.test, "True")
            yield file.put("condition", node.test, "False")
            if isinstance(node.body[-1], ast.Return):  # an early one: what follows is done as well
                yield file.put("removal", node.body[-1], "pass")
        case ast.IfExp():
            yield file.put("condition", node, f"({file.said(node.body)})")
            yield file.put("condition", node, f"({file.said(node.orelse)})")
        case ast.Constant():
            yield from _constant(file, node)
        case ast.Attribute(value=ast.Name(id=kind), attr=name) if name in _FAMILIES.get(kind, ()):
            family = _FAMILIES[kind]
            yield file.put("constant", node, f"{kind}.{family[(family.index(name) + 1) % len(family)]}")
        case ast.Attribute(value=ast.Attribute(attr=kind) as owner, attr=name) if name in _FAMILIES.get(
            kind, ()
        ):
            family = _FAMILIES[kind]
            instead = family[(family.index(name) + 1) % len(family)]
            yield file.put("constant", node, f"{file.said(owner)}.{instead}")
        case ast.Name(id=name) if name in _TWINS:
            yield file.put("arithmetic", node, _TWINS[name])
        case ast.Name(id=name, ctx=ast.Load()) if name in (
            "BEAT_S",
            "COUNTERS_S",
            "HOLD_PATIENCE_S",
            "RELAX_S",
        ):
            yield file.put("name", node, _SIBLING[name])
        case ast.Name(id=name, ctx=ast.Load()) if file.binds(_SIBLING.get(name), node.lineno):
            yield file.put("name", node, _SIBLING[name])
        case ast.Attribute(attr=name, value=owner, ctx=ast.Load()) if name in _SIBLING:
            instead = f"{file.said(owner)}.{_SIBLING[name]}"
            if file.has(instead):  # what has no such attribute only crashes
                yield file.put("name", node, instead)
        case ast.Subscript(slice=ast.Name() | ast.Attribute() | ast.BinOp()):
            yield file.put("index", node.slice, "0")
            yield file.put("index", node.slice, f"({file.said(node.slice)}) - 1")
        case ast.Call() if len(node.args) > 1 and file.said(node.func) not in _TWINS:
            for one, other in pairwise(node.args):
                if _unit(file.said(one)) != _unit(file.said(other)):
                    continue  # a number for an object only crashes
                first, last = file.span(one)[0], file.span(other)[1]
                gap = file.text[file.span(one)[1] : file.span(other)[0]].decode()
                yield "arguments", first, last, f"{file.said(other)}{gap}{file.said(one)}"
        case ast.Expr(value=ast.Call()):
            yield file.put("removal", node, "pass")
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript(), *_]):
            yield file.put("removal", node, "pass")
            if not isinstance(node.value, ast.Constant):
                yield file.put("value", node.value, "0")
        case ast.Return(value=ast.expr() as value) if not isinstance(value, ast.Constant):
            yield file.put("value", value, "0")
        case ast.Continue() | ast.Break():
            yield file.put("removal", node, "pass")
        case _:
            pass


def _unit(said: str) -> str:
    """What an expression ends with: names of one kind have one suffix."""
    return "" if said.replace(".", "").isdigit() else said.rpartition("_")[2].rstrip("])")


def _sign(operator: ast.operator) -> str:
    signs = {
        ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.LShift: "<<", ast.RShift: ">>", ast.BitAnd: "&",
        ast.BitOr: "|", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**",
    }  # fmt: skip
    return signs[type(operator)]


def _compare(file: _File, node: ast.Compare) -> Iterator[Change]:
    signs: dict[type[ast.cmpop], str] = {
        ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.Is: "is",
        ast.IsNot: "is not", ast.In: "in", ast.NotIn: "not in",
    }  # fmt: skip
    operands = [node.left, *node.comparators]
    for operator, left, right in zip(node.ops, operands, operands[1:], strict=False):
        for instead in _COMPARISONS[type(operator)]:
            yield file.between("comparison", left, right, signs[type(operator)], instead)


def _constant(file: _File, node: ast.Constant) -> Iterator[Change]:
    value = node.value
    if isinstance(value, bool):
        yield file.put("constant", node, str(not value))
    elif isinstance(value, int) and file.said(node).lower().startswith("0x"):
        yield file.put("constant", node, f"0x{value ^ 1:X}")
    elif isinstance(value, int | float):
        for number in other_numbers(value, whole=isinstance(value, int)):
            yield file.put("constant", node, f"{number:.0f}" if isinstance(value, int) else repr(number))
