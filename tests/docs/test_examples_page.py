"""docs/examples.md: its commands run, on the recordings that it speaks of, and its figures are what they print."""

from __future__ import annotations

import glob
import re
import shlex
from pathlib import Path

import pytest
from recordings import AT_HAND, REAL

from snakebot.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\$ (snakebot .*)$", PAGE, re.MULTILINE)
TOLD = re.findall(r"^(?:Explained|With that|On the robot|Of the gap).*$", PAGE, re.MULTILINE)


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL):
        (tmp_path / text.split()[1]).write_text(text)
    (tmp_path / "recordings").symlink_to(REAL)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    """A command as a shell would give it, and what it prints."""
    words = [file for word in shlex.split(command) for file in (sorted(glob.glob(word)) or [word])]
    with pytest.raises(SystemExit) as ended:
        main(words[1:])
    out, err = capsys.readouterr()
    assert ended.value.code == 0, (command, err)
    return out


@AT_HAND
def test_the_recordings_are_read(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "bare: 32 runs, 1 joint" in run(COMMANDS[0], capsys)
    assert "10 to 20 s tell more" in run(COMMANDS[1], capsys)


@AT_HAND
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_soft_servo_is_found_as_the_page_says(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The other gain and the PWM servo take minutes: of those the page's commands are tried with one effect alone."""
    printed = ""
    for command in COMMANDS:
        if "diagnose bare" in command:
            command += " --only rate_limit"
        elif "diagnose kp_800" in command:
            command += " --only position_loop"
        printed += run(command, capsys)
    assert (lab / "bare.html").is_file()
    assert (lab / "kp_800.json").is_file()
    assert len(TOLD) == 6
    soft = [line for line in TOLD if "44.3 ms" not in line and "4.65" not in line and "the rest" not in line]
    assert len(soft) == 3
    for line in soft:
        assert line in printed
    assert "RMS difference of all joints: 0.398 deg" in printed
    assert "stiffness 1.57 N m/rad" in printed


def test_the_page_writes_what_its_pictures_are_drawn_from() -> None:
    tool = (ROOT / "tools" / "make_pictures.py").read_text(encoding="utf-8")
    written = re.findall(r"--json (\S+)", PAGE)
    assert sorted(re.findall(r'\("(\S+\.json)", ', tool)) == sorted(written)
    for picture in re.findall(r"\]\((\S+\.png)\)", PAGE):
        assert (ROOT / "docs" / picture).is_file()
