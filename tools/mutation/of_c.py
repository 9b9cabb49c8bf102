"""Mutants of a C file, made on its syntax tree (tree-sitter)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

import tree_sitter
import tree_sitter_c
from tree_sitter import Node

from mutation.mutant import Change, other_numbers

_PARSER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_c.language()))
_COMPARISONS = {
    "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
}  # fmt: skip
_ARITHMETIC = {
    "+": "-", "-": "+", "*": "/", "/": "*", "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "|", "%": "/",
    "+=": "-=", "-=": "+=", "&=": "|=", "|=": "&=", "^=": "|=", "++": "--", "--": "++",
}  # fmt: skip
_LOGIC = {"&&": "||", "||": "&&"}
_TWINS = {"fminf": "fmaxf", "fmaxf": "fminf", "true": "false", "false": "true"}
# Names of one kind: each stands in for the one before.
_FAMILIES = (
    ("DISARMED", "ARMED", "HOLDING", "STOPPED", "FAULT"),
    ("ACTIVE", "FREE", "RIGID"),
    ("OK", "BAD_VALUE", "BAD_JOINT", "FORBIDDEN", "HELD"),
    ("BEAT_US", "SECOND_US"),
    ("SB_WATCHDOG_US", "SB_HOLD_PATIENCE_US", "SB_RELAX_US"),
)
# Members of one kind, and variables: what a slip of the pen writes for one another.
_SIBLINGS = (
    ("beat_due_us", "sample_due_us", "second_due_us"),
    ("received", "corrupt", "dropped", "clamped"),
    ("fed_us", "fault_since_us"),
    ("angle_rad", "speed_rad_s", "acceleration_rad_s2"),
    ("applied_rad", "target_rad"),
    ("slow", "fast"),
    ("near", "other"),
    ("low", "high"),
    ("powered", "known", "reading"),
    ("first_rad", "second_rad", "third_rad"),
    ("measured", "applied"),
    ("sequence", "sample"),
    ("voltage_mv", "current_ma", "temperature_dc"),
    ("shortest_ns", "longest_ns"),
    ("firmware_major", "firmware_minor", "firmware_patch"),
    ("dt_s", "dt_before_s"),
    ("value", "largest"),
    ("now_us", "due_us"),
    ("token", "number"),
)
_NEXT = {name: family[(i + 1) % len(family)] for family in _FAMILIES for i, name in enumerate(family)}
_SIBLING = {name: family[(i + 1) % len(family)] for family in _SIBLINGS for i, name in enumerate(family)}
_POINTERS = {
    "board", "joints", "modes", "limiter", "assembler", "frame", "step", "one", "tick", "latch", "group", "body",
}  # fmt: skip
_EITHER_WAY = ("fminf", "fmaxf", "memset", "memcpy", "SEND")  # the same, or no program
_NUMBER = re.compile(r"(0[xX][0-9a-fA-F]+|[0-9.]+(?:[eE][-+]?[0-9]+)?)([uUlLfF]*)")


def changes(text: bytes) -> Iterator[Change]:
    """All changes of one file, in its order."""
    tree = _PARSER.parse(text)
    assert not tree.root_node.has_error
    yield from _walk(tree.root_node, text)


def _put(operator: str, node: Node, instead: str) -> Change:
    return operator, node.start_byte, node.end_byte, instead


def _said(node: Node | None) -> str:
    assert node is not None
    assert node.text is not None
    text: str = node.text.decode()
    return text


def _walk(node: Node, text: bytes) -> Iterator[Change]:
    if node.type in ("preproc_include", "preproc_ifdef", "comment", "preproc_function_def"):
        if node.type == "preproc_ifdef":  # the guard of a header: its name is no condition
            for child in node.children[2:]:
                yield from _walk(child, text)
        return
    if node.type == "preproc_def":
        yield from _defined(node)
        return
    yield from _of(node)
    for child in node.children:
        yield from _walk(child, text)


def _of(node: Node) -> Iterator[Change]:
    match node.type:
        case "binary_expression":
            yield from _binary(node)
            yield from _bound(node)
        case "unary_expression":
            sign, argument = node.children[0], node.child_by_field_name("argument")
            if _said(sign) in ("!", "-", "~"):
                yield _put("condition" if _said(sign) == "!" else "arithmetic", node, _said(argument))
        case "update_expression" | "assignment_expression":
            operator = node.child_by_field_name("operator")
            if operator is not None and _said(operator) in _ARITHMETIC:
                yield _put("arithmetic", operator, _ARITHMETIC[_said(operator)])
            elif node.type == "assignment_expression":
                right = node.child_by_field_name("right")
                assert right is not None
                if right.type not in ("number_literal", "true", "false", "compound_literal_expression"):
                    yield _put("value", right, "0")
        case "if_statement" | "while_statement":
            condition = node.child_by_field_name("condition")
            assert condition is not None
            yield _put("condition", condition, "(true)")
            yield _put("condition", condition, "(false)")
        case "conditional_expression":
            yield _put("condition", node, f"({_said(node.child_by_field_name('consequence'))})")
            yield _put("condition", node, f"({_said(node.child_by_field_name('alternative'))})")
        case "number_literal":
            yield from _number(node)
        case "true" | "false":
            yield _put("constant", node, _TWINS[_said(node)])
        case "identifier":
            name = _said(node)
            if name in _NEXT:
                yield _put("constant", node, _NEXT[name])
            elif name in _TWINS:
                yield _put("arithmetic", node, _TWINS[name])
            elif name in _SIBLING and _is_read(node):
                yield _put("name", node, _SIBLING[name])
        case "field_identifier":
            declared = node.parent is not None and node.parent.type == "field_declaration"
            if _said(node) in _SIBLING and not declared:
                yield _put("name", node, _SIBLING[_said(node)])
        case "argument_list":
            called = node.parent.child_by_field_name("function") if node.parent is not None else None
            if called is not None and _said(called) not in _EITHER_WAY:
                yield from _swapped(node)
        case "subscript_expression":
            index = node.child_by_field_name("index")
            assert index is not None
            if index.type != "number_literal":
                yield _put("index", index, "0")
                yield _put("index", index, f"{_said(index)} + 1")
                yield _put("index", index, f"{_said(index)} - 1")
        case "expression_statement" | "break_statement" | "continue_statement":
            if node.named_child_count or node.type != "expression_statement":
                yield _put("removal", node, ";")
        case "initializer_pair":
            yield _put("removal", node, "")
        case "return_statement":
            if node.named_child_count and node.named_children[0].type not in (
                "number_literal", "true", "false", "compound_literal_expression",
            ):  # fmt: skip
                yield _put("value", node.named_children[0], "0")
            if _is_early(node):
                yield _put("removal", node, ";")
        case "init_declarator":
            value = node.child_by_field_name("value")
            assert value is not None
            if value.type not in ("number_literal", "true", "false", "initializer_list"):
                yield _put("value", value, "0")
        case _:
            pass


def _is_read(node: Node) -> bool:
    """The name of a variable where it is used, not where it is declared."""
    parent = node.parent
    return (
        parent is not None
        and not parent.type.endswith("declarator")
        and parent.type != "parameter_declaration"
    )


def _is_early(node: Node) -> bool:
    """A return that ends what an `if` stands before, where the function goes on after it."""
    block = node.parent
    branch = block.parent if block is not None else None
    return branch is not None and branch.type == "if_statement" and branch.next_named_sibling is not None


def _swapped(node: Node) -> Iterator[Change]:
    """Two arguments beside each other, each in the other's place; pointers aside, which crash."""
    for one, other in pairwise(node.named_children):
        kinds = {one.type, other.type}
        if kinds & {"comment", "pointer_expression"} or {_said(one), _said(other)} & _POINTERS:
            continue
        between = _said(node)[one.end_byte - node.start_byte : other.start_byte - node.start_byte]
        yield "arguments", one.start_byte, other.end_byte, f"{_said(other)}{between}{_said(one)}"


def _bound(node: Node) -> Iterator[Change]:
    """The end of a loop, one sooner."""
    loop = node.parent
    operator, right = node.child_by_field_name("operator"), node.child_by_field_name("right")
    if loop is not None and loop.type == "for_statement" and right is not None and _said(operator) == "<":
        yield _put("bound", right, f"{_said(right)} - 1")


def _binary(node: Node) -> Iterator[Change]:
    operator = node.child_by_field_name("operator")
    assert operator is not None
    said = _said(operator)
    for instead in _COMPARISONS.get(said, ()):
        yield _put("comparison", operator, instead)
    if said in _ARITHMETIC:
        yield _put("arithmetic", operator, _ARITHMETIC[said])
    if said in _LOGIC:
        yield _put("logic", operator, _LOGIC[said])
        yield _put("condition", node, _said(node.child_by_field_name("left")))
        yield _put("condition", node, _said(node.child_by_field_name("right")))


def _others(said: str) -> list[str]:
    match = _NUMBER.fullmatch(said)
    if match is None:
        return []
    digits, suffix = match.groups()
    if digits.lower().startswith("0x"):
        return [f"0x{int(digits, 16) ^ 1:X}{suffix}"]
    whole = digits.isdigit()
    numbers = other_numbers(float(digits), whole=whole, negative="u" not in suffix)
    return [f"{number:.0f}{suffix}" if whole else f"{number!r}{suffix}" for number in numbers]


def _number(node: Node) -> Iterator[Change]:
    parent = node.parent
    row = parent is not None and parent.type == "initializer_list"
    if row and parent is not None and parent.parent is not None and parent.parent.type == "initializer_list":
        return  # the generated table: rows of numbers in rows
    for instead in _others(_said(node))[: 1 if row else None]:
        yield _put("constant", node, instead)


def _defined(node: Node) -> Iterator[Change]:
    """The numbers in a macro's value."""
    value = node.child_by_field_name("value")
    if value is None:
        return
    said = re.sub(r"/\*.*", "", _said(value))
    for match in _NUMBER.finditer(said):
        if match.start() and (said[match.start() - 1].isalnum() or said[match.start() - 1] == "_"):
            continue
        for instead in _others(match.group()):
            first = value.start_byte + match.start()
            yield "constant", first, first + len(match.group()), instead
