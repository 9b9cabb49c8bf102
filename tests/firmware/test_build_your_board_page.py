"""Every command of docs/build-your-board.md is one that works."""

from __future__ import annotations

import re
import select
import shlex
import subprocess
from typing import Any

import pytest
from building import BUILD, FIRMWARE, ROOT, make, need
from click.testing import CliRunner
from tool_calls import called

from snakebot.cli.main import cli

PAGE = (ROOT / "docs/build-your-board.md").read_text(encoding="utf-8")
BLOCKS = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)).replace("\\\n", " ")
SNAKEBOT = sorted(set(re.findall(r"(?:^|`)(snakebot [^`\n#]+)", PAGE, re.MULTILINE)))


def test_the_page_has_commands() -> None:
    assert len(SNAKEBOT) >= 5
    assert "make -C firmware_protocol/firmware" in BLOCKS


@pytest.mark.parametrize("command", SNAKEBOT)
def test_snakebot_commands(command: str) -> None:
    """Runs are checked dry; everything else is parsed to its end: a wrong option or command fails."""
    words = shlex.split(command.strip())[1:]
    if words[0] == "run":
        words = [*["sim:" if word == "PORT" else word for word in words], "--dry-run"]
        result = CliRunner().invoke(cli, words, catch_exceptions=False)
        assert result.exit_code == 0, result.output
        return
    group: Any = cli  # a group, then the command itself
    context = None
    while words and hasattr(group, "get_command"):
        context = group.make_context("snakebot", [], resilient_parsing=True)
        name = words.pop(0)
        found = group.get_command(context, name)
        assert found is not None, f"there is no {name}"
        group = found
    group.make_context(command, words)


def test_the_linux_program_is_where_the_page_says_and_prints_what_it_says() -> None:
    make("all")
    for options, start in (([], "serial:/dev/pts/"), (["--slcan"], "can:slcan//dev/pts/")):
        process = subprocess.Popen(
            [str(BUILD / "snakebot_board"), *options], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        assert select.select([process.stdout], [], [], 10.0)[0]
        assert process.stdout.readline().startswith(start)
        process.terminate()
        process.wait(10.0)
        process.stdout.close()


def test_the_cortex_m_build_prints_what_the_page_says() -> None:
    need("arm-none-eabi-gcc")
    (BUILD / "snakebot_cortex_m.elf").unlink(missing_ok=True)
    printed = make("cortex_m")
    flash, ram, stack = (
        int(re.search(pattern, printed)[1])  # type: ignore[index]
        for pattern in (r"flash (\d+)", r"RAM (\d+)", r"worst stack (\d+)")
    )
    said = re.search(r"about (\S+) KiB, (\S+) KiB .*?and (\S+) KiB", PAGE, re.DOTALL)
    assert said is not None
    kib = [float(number) for number in said.groups()]
    assert [flash / 1024, ram / 1024, stack / 1024] == pytest.approx(kib, rel=0.15)


def test_the_tools_are_there_and_the_generated_files_up_to_date() -> None:
    tools = re.findall(r"python (tools/\S+)", BLOCKS)
    assert len(tools) == 5
    for tool in tools:
        option = "--check" if "make_" in tool else "--help"
        if "coverage" not in tool:
            done = called(ROOT / tool, option)
            assert done.returncode == 0, done.stderr
        assert (ROOT / tool).exists()


def test_the_table_of_the_hal_is_complete() -> None:
    declared = set(re.findall(r"\b(hal_[a-z_]+)\(", (FIRMWARE / "core/hal.h").read_text(encoding="utf-8")))
    assert declared == set(re.findall(r"`(hal_[a-z_]+)`", PAGE))
