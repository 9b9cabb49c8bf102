"""``snakebot board`` and ``snakebot doctor`` against a simulated board in a process of its own."""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from firmware_protocol.catalogue import Mode, catalogue_hash
from snakebot.cli.main import main

CONNECT = Path(__file__).parents[2] / "docs" / "connect.md"
COMMAND = [sys.executable, "-m", "snakebot.cli.main"]


@dataclass
class Result:
    status: int
    out: str
    err: str


def snakebot(*arguments: str) -> Result:
    """The command, in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as ended:
        main(list(arguments))
    code = ended.value.code
    return Result(code if isinstance(code, int) else 0, out.getvalue(), err.getvalue())


@contextlib.contextmanager
def served(*arguments: str, places: Path | None = None) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """``snakebot board sim`` with these arguments, and the first line that it prints."""
    serve = [*COMMAND, "board", "sim"] if places is None else [sys.executable, "-c", SERVE, str(places)]
    process = subprocess.Popen(
        [*serve, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


# Its registrations are in a place of our own: what other boards on this computer write is not seen.
SERVE = """
import sys
from pathlib import Path
from snakebot.control import registry
registry.SHARED = (Path(sys.argv[1]),)
from snakebot.cli.main import main
main(["board", "sim", *sys.argv[2:]])
"""


@pytest.fixture(scope="module")
def port(places: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A board behind a pseudo-terminal with a name."""
    link = tmp_path_factory.mktemp("port") / "snake"
    with served("--serial", "--symlink", str(link), places=places) as (process, line):
        assert line == f"--port serial:{link}"
        yield f"serial:{link}"
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0
        assert not link.is_symlink()
        assert not list(places.rglob("*.json"))


@pytest.fixture
def no_other_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    """This computer has no adapters, and no network to ask."""
    from snakebot.cli import board_list
    from snakebot.links import discover

    monkeypatch.setattr(discover, "serial_ports", list)
    monkeypatch.setattr(discover, "can_ports", list)
    monkeypatch.setattr(board_list, "MULTICAST", "serial:/dev/there-is-none")


@pytest.mark.usefixtures("no_other_ports")
def test_list_finds_the_simulated_board(port: str) -> None:
    (found,) = json.loads(snakebot("board", "list", "--json").out)
    assert found["port"] == port
    assert found["what"].startswith("simulated board (process ")
    assert port in snakebot("board", "list").out


@pytest.mark.usefixtures("no_other_ports")
def test_list_asks_who_is_there(port: str) -> None:
    board, nobody = json.loads(snakebot("board", "list", "--probe", "--json").out)
    assert board["board"]["joints"] == 5
    assert board["board"]["simulated"] is True
    assert nobody["board"] is None
    assert "no such device" in nobody["answer"]
    text = snakebot("board", "list", "--probe").out
    assert "-> simulated board 1, 5 joints" in text


@pytest.mark.usefixtures("no_other_ports")
def test_list_of_nothing_says_what_to_do(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from snakebot.control import registry

    monkeypatch.setattr(registry, "SHARED", (tmp_path,))
    result = snakebot("board", "list")
    assert "board sim" in result.out
    assert json.loads(snakebot("board", "list", "--json").out) == []


def test_info_says_who_the_board_is(port: str) -> None:
    info = json.loads(snakebot("board", "info", port, "--json").out)
    assert info["joints"] == len(info["measured_rad"]) == len(info["applied_rad"]) == 5
    assert info["catalogue_hash"] == f"{catalogue_hash():08x}"
    assert info["counts_per_rev"] == 8192
    assert info["watchdog_ms"] == 100
    assert info["mode"] == "disarmed"
    assert info["counters"]["corrupt"] == 0
    text = snakebot("board", "info", port).out
    assert re.search(r"mode +disarmed", text)


@pytest.fixture(scope="module")
def findings(port: str) -> dict[str, dict[str, str]]:
    """What doctor finds on the board's port, by name."""
    result = snakebot("doctor", port, "--json")
    assert result.status == 0
    return {finding["what"]: finding for finding in json.loads(result.out)["findings"]}


def test_doctor_finds_a_healthy_board(findings: dict[str, dict[str, str]]) -> None:
    assert {"versions", "clock source", "timer", "use", "round trip"} <= set(findings)
    for what in ("device", "rights", "board", "agreement", "mode", "wire"):
        assert findings[what]["status"] == "ok", findings[what]
    assert findings["agreement"]["found"].count(f"{catalogue_hash():08x}") == 2
    assert re.search(r"\d+\.\d\d ms \(median\), \d+\.\d\d ms \(p99\)", findings["round trip"]["found"])


@pytest.mark.parametrize(
    ("argument", "status", "text"),
    [
        ("serial:/dev/there-is-none", 3, "FAIL device"),
        ("can:slcan//dev/there-is-none", 3, "FAIL device"),
        ("serial:/dev/null", 3, "not a serial device"),
        ("serial:socket://127.0.0.1:1", 3, "FAIL board"),
    ],
)
def test_doctor_says_what_is_wrong(argument: str, status: int, text: str) -> None:
    result = snakebot("doctor", argument)
    assert result.status == status
    assert text in result.out
    assert json.loads(snakebot("doctor", argument, "--json").out)["exit_status"] == status


def test_doctor_of_a_port_that_is_taken(port: str) -> None:
    from snakebot.links import open_link

    with open_link(port):
        result = snakebot("doctor", port)
    assert result.status == 3
    assert "in use by another program" in result.out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["board", "sim"], "--serial, --tcp"),
        (["board", "sim", "--serial", "--tcp", "5"], "choose one"),
        (["board", "sim", "--tcp", "host"], "HOST:PORT"),
        (["board", "sim", "--tcp", "127.0.0.1:65536"], "HOST:PORT"),
        (["board", "sim", "--can", "socketcan"], "INTERFACE/CHANNEL"),
        (["board", "sim", "--can", "nonsense/x"], "no CAN interface"),
        (["board", "sim", "--tcp", "0", "--symlink", "x"], "pseudo-terminal"),
        (["board", "sim", "--serial", "--effect", "nonsense"], "nonsense"),
        (["board", "sim", "--serial", "--fault", "free:6"], "no joint 6"),
        (["board", "sim", "--serial", "--robot", "nonsense"], "nonsense"),
        (["board", "sim", "--serial", "--seed", "x"], "seed"),
        (["board", "info", "nonsense"], "sim:, serial:, can:, feetech: or dynamixel:"),
        (["doctor", "nonsense"], "sim:, serial:, can:, feetech: or dynamixel:"),
        (["doctor", "can:nonsense/x"], "no CAN interface"),
        (["board", "nonsense"], "nonsense"),
    ],
)
def test_bad_input_is_one_line_and_status_2(arguments: list[str], text: str) -> None:
    result = snakebot(*arguments)
    assert result.status == 2
    assert text in result.err
    assert result.out == ""
    assert len(result.err.replace("\nTry: ", " ").strip().splitlines()) == 1


def test_a_symlink_does_not_overwrite_a_file(tmp_path: Path) -> None:
    file = tmp_path / "precious"
    file.write_text("data")
    result = snakebot("board", "sim", "--serial", "--symlink", str(file))
    assert result.status == 2
    assert file.read_text() == "data"


def test_tcp_is_for_this_computer_and_for_more_than_one_host() -> None:
    from snakebot.board import Board
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link

    with served("--tcp", "--json") as (process, line):
        port = json.loads(line)["port"]
        assert re.fullmatch(r"serial:socket://127\.0\.0\.1:\d+", port)
        with open_link(port) as one, open_link(port) as other:
            for link in (one, other):
                assert Board(link, MonotonicClock()).connect(10.0).joints == 5
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0


def test_slcan_with_a_joint_that_breaks() -> None:
    from snakebot.board import Board
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link

    with served("--can", "slcan", "--fault", "rigid:4=20", "--json") as (_, line):
        port = json.loads(line)["port"]
        assert re.fullmatch(r"can:slcan//dev/\S+\?bitrate=1000000", port)
        with open_link(port) as link:
            clock = MonotonicClock()
            board = Board(link, clock)
            board.connect(10.0)
            while board.last_reading is None or abs(board.last_reading.measured_rad[3] - 0.349) > 0.01:
                board.poll(0.1)  # it goes there by itself, disarmed as the board is
            assert board.mode is Mode.DISARMED


def commands() -> list[str]:
    """Every snakebot command in the document that does not wait for Ctrl-C."""
    found = re.findall(r"^\$ (snakebot .*)$", CONNECT.read_text(encoding="utf-8"), re.MULTILINE)
    return [command for command in found if " board sim " not in command]


def test_the_document_shows_commands() -> None:
    assert len(commands()) >= 4


@pytest.mark.usefixtures("no_other_ports")
@pytest.mark.parametrize("command", commands())
def test_every_command_of_the_document_works(
    command: str, port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = snakebot(
        *shlex.split(command)[1:-1], *[shlex.split(command)[-1].replace("serial:/dev/ttyUSB0", port)]
    )
    assert result.status == 0, result.err


def test_the_document_names_every_finding(findings: dict[str, dict[str, str]]) -> None:
    text = CONNECT.read_text(encoding="utf-8")
    for what in set(findings) - {"versions", "board", "driver"}:
        assert what in text


def test_the_simulated_board_keeps_its_promises() -> None:
    result = snakebot("board", "test", "--case", "answers_pings", "--case", "clock_goes_right", "--json")
    assert result.status == 0
    outcomes = json.loads(result.out)
    assert [(each["case"], each["verdict"]) for each in outcomes] == [
        ("answers_pings", "passed"),
        ("clock_goes_right", "passed"),
    ]
    assert (
        "2 passed" in snakebot("board", "test", "--case", "answers_pings", "--case", "clock_goes_right").out
    )


def test_a_broken_promise_is_status_5_with_the_rule_and_the_traffic(monkeypatch: pytest.MonkeyPatch) -> None:
    from snakebot.softboard import SoftBoard

    right = SoftBoard._shows_us
    monkeypatch.setattr(SoftBoard, "_shows_us", lambda self, t_s: right(self, 1.03 * t_s))
    result = snakebot("board", "test", "--case", "clock_goes_right")
    assert result.status == 5
    assert "FAIL clock_goes_right" in result.out
    assert "goes right to 1 %" in result.out
    assert "Pong" in result.out


def test_a_real_robot_is_not_moved_unasked(monkeypatch: pytest.MonkeyPatch) -> None:
    from snakebot.board import Board

    connect = Board.connect
    monkeypatch.setattr(Board, "connect", lambda self: replace(connect(self), simulated=False))
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    result = snakebot("board", "test", "--case", "answers_pings")
    assert result.status == 2
    assert "--yes" in result.err
    assert snakebot("board", "test", "--case", "answers_pings", "--yes").status == 0


def test_cases_are_listed_and_misspelt_ones_refused() -> None:
    assert "answers_pings\n    Ping is answered" in snakebot("board", "test", "--list").out
    result = snakebot("board", "test", "--case", "answers_ping")
    assert result.status == 2
    assert "did you mean answers_pings?" in result.err


def test_trims_and_zeros_are_stored_by_the_board() -> None:
    with served("--serial") as (_, line):
        port = line.split()[-1]
        before = json.loads(snakebot("board", "info", port, "--json").out)["measured_rad"]
        told = snakebot("board", "trim", port, "3", "-1.5", "--json")
        assert (told.status, json.loads(told.out)) == (0, {"port": port, "joint": 3, "trim_deg": -1.5})
        assert snakebot("board", "zero", port, "2", "100").out.startswith("joint 2: zero 100 counts")
        after = json.loads(snakebot("board", "info", port, "--json").out)["measured_rad"]
        moved = [b - a for a, b in zip(before, after, strict=True)]
        assert abs(moved[1]) == pytest.approx(100 * 2 * math.pi / 8192, abs=0.01)
        assert all(abs(each) < 0.01 for joint, each in enumerate(moved) if joint != 1)
        no_joint = snakebot("board", "trim", port, "6", "1")
        assert (no_joint.status, "the board has joints 1 to 5" in no_joint.err) == (2, True)
        too_far = snakebot("board", "trim", port, "3", "170")
        assert (too_far.status, "trims of at most 17.2 deg" in too_far.err) == (2, True)


@pytest.mark.parametrize(
    "words", [("trim", "sim:", "1", "1"), ("trim", "sim:", "1", "nan"), ("zero", "sim:", "1", "9")]
)
def test_a_trim_that_would_be_forgotten_is_refused(words: tuple[str, ...]) -> None:
    assert snakebot("board", *words).status == 2
