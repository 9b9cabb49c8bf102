"""Tables on a terminal: whatever names runs have, no column is lost and no line is wider than the screen."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.analysis.as_text import table_text
from snakebot.report import Column, Table
from snakebot.text_table import set_in_columns, shortened_apart

HEAD = ["run", "TE", "speed", "fault", "effect", "ended"]
RIGHT = [False, True, True, False, False, False]


@given(
    names=st.lists(st.text("ab_", min_size=1, max_size=150), min_size=1, max_size=5),
    effect=st.text("xyz=", max_size=200),
    screen=st.integers(60, 200),
)
def test_no_column_is_hidden_and_no_number_cut_on_any_screen(
    names: list[str], effect: str, screen: int
) -> None:
    rows = [[name, f"{n}.125", "0.131", "free:3", effect, "interrupted"] for n, name in enumerate(names)]
    lines = set_in_columns([HEAD, *rows], RIGHT, screen=screen)
    assert max(map(len, lines)) <= screen
    text = "\n".join(lines)
    for told in (*HEAD, "free:3", "interrupted", *(row[1] for row in rows)):
        assert re.search(rf"(^|\s){re.escape(told)}(\s|$)", text), told


def test_a_table_that_fits_is_one_block_and_units_stand_once() -> None:
    rows = [["run", "speed", "effect"], ["", "m/s", ""], ["one", "0.131", ""], ["two", "12", "lag"]]
    assert set_in_columns(rows, [False, True, False], 2, 80) == [
        "run  speed  effect",
        "       m/s",
        "one  0.131",
        "two     12  lag",
    ]
    wide = [[*row[:2], row[2].ljust(50, "e")] for row in rows]
    blocks = set_in_columns(wide, [False, True, False], 2, 60)
    assert blocks[:4] == ["run  speed", "       m/s", "one  0.131", "two     12"]
    assert blocks[4] == ""
    assert [line.split()[0] for line in blocks[5:]] == ["run", "e" * 50, "one", "two"]


def test_names_that_differ_in_their_middle_stay_apart() -> None:
    names = [f"{'a' * 60}{letter}{'z' * 60}" for letter in "bc"]
    short = shortened_apart([*names, "short"], 30)
    assert len(set(short)) == 3
    assert max(map(len, short)) <= 30
    assert short[2] == "short"
    assert shortened_apart(["x" * 90] * 2, 30)[0] == shortened_apart(["x" * 90], 30)[0]


def test_a_report_table_says_what_its_rows_are_about_in_each_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snakebot.analysis.as_text.screen_columns", lambda: 60)
    columns = [
        Column("omega", "rad/s"),
        Column("alpha", "deg"),
        *(Column(f"figure {n}", "m/s") for n in range(9)),
    ]
    lines = table_text(
        Table(columns, [[2.0, 66.0, *(n / 8 for n in range(9))]], "Speeds", keys=2)
    ).splitlines()
    heads = [line for line in lines if line.startswith("omega")]
    assert len(heads) == 3
    assert all(head.split()[:2] == ["omega", "alpha"] for head in heads)
    assert all(f"figure {n}" in "".join(heads) for n in range(9))


def test_help_names_things_in_words() -> None:
    """Nobody should need the paper to read a help text."""
    import click

    from snakebot.cli.main import cli

    numbered = re.compile(r"Tables? [IV]+\b|Figs?\. ?\d|Section [IVX]+\b|\(\d\d\)")

    def texts(command: click.Command, name: str, context: click.Context) -> list[tuple[str, str]]:
        here = click.Context(command, info_name=name, parent=context)
        found = [(name, command.get_help(here))]
        if isinstance(command, click.Group):
            for sub in command.list_commands(here):
                child = command.get_command(here, sub)
                assert child is not None
                found += texts(child, f"{name} {sub}", here)
        return found

    found = []
    for name in ("study", "analyze", "compare", "log"):
        context = click.Context(cli, info_name="snakebot")
        command = cli.get_command(context, name)
        assert command is not None
        found += texts(command, name, context)
    assert len(found) > 12
    assert [name for name, text in found if numbered.search(text)] == []
