"""docs/steering.md: its commands run, with a tracker where they want one, and its block of Python does."""

from __future__ import annotations

import json
import re
import shlex
import socket
import threading
from pathlib import Path

import pytest

from snakebot.cli.main import main
from snakebot.runlog import read_log

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "steering.md").read_text(encoding="utf-8")
COMMANDS = [line.strip() for line in PAGE.splitlines() if line.startswith("    snakebot ")]
FAST = [command for command in COMMANDS if "--fast" in command]


def call(*words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0, words


@pytest.mark.parametrize("command", FAST)
def test_a_command_holds_its_course(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    call(*shlex.split(command)[1:], "--cycles", "3", "--log", "a.mcap")
    assert "course: heading error at the end" in capsys.readouterr().out
    assert read_log("a.mcap").steering_t_s.size >= 3


@pytest.mark.slow
@pytest.mark.real_time
def test_the_command_with_a_tracker_takes_its_poses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In real time, with a tracker that says what the page says, and some rubbish."""
    monkeypatch.chdir(tmp_path)
    (command,) = [command for command in COMMANDS if command not in FAST]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [
        word.replace("serial:/dev/ttyUSB0", "sim:").replace("9000", str(port))
        for word in shlex.split(command)
    ]
    sample = json.loads(re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)[0])
    assert set(sample) == {"t", "x", "y", "heading"}
    done = threading.Event()

    def track() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            number = 0
            while not done.wait(0.03):
                number += 1
                said = {**sample, "t": sample["t"] + 0.03 * number, "x": sample["x"] + 1e-3 * number}
                data = b"{broken" if number % 10 == 0 else json.dumps(said).encode()
                out.sendto(data, ("127.0.0.1", port))

    thread = threading.Thread(target=track, daemon=True)
    thread.start()
    try:
        call(*words[1:], "--duration", "9", "--log", "a.mcap", "--json")
    finally:
        done.set()
        thread.join()
    told = json.loads(capsys.readouterr().out.splitlines()[-1])["steering"]
    assert told["decisions"] >= 2
    assert told["bad_poses"] >= 10
    log = read_log("a.mcap")
    assert log.metadata["pose_source"] == f"udp://127.0.0.1:{port}"
    assert log.pose[:, 1] == pytest.approx(sample["y"])  # not the simulated board's
    assert [event.kind for event in log.events].count("pose_damaged") == 1
    assert log.steering["heading_rad"] == pytest.approx(sample["heading"])


def test_the_block_of_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(block, "docs/steering.md", "exec"), names)
    assert list(Path("runs").glob("*.mcap"))


def test_the_tracker_in_the_text_is_python() -> None:
    (outline,) = re.findall(r"```text\n(.*?)```", PAGE, flags=re.DOTALL)
    compile(outline, "docs/steering.md", "exec")
