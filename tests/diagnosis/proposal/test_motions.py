"""The file of the motions: the one that comes with snakebot is sound, and of another the first fault is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from sessions import bench, make_session

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.missing import missing
from snakebot.diagnosis.plan import plan
from snakebot.diagnosis.proposal import motions as of_file
from snakebot.diagnosis.proposal.motions import DURATION_S, WrittenGait, known_motions, load_motions
from snakebot.errors import BadInputError
from snakebot.gait import parse_probe

GAIT = "{alpha_deg: 4, beta_deg: 80, omega_rad_s: 0.5}"


def text(start: str = GAIT, gaits: str = GAIT, probes: str = "", lifted: str = "") -> str:
    """A file with these motions, a section a line."""
    return f"start: [{start}]\ngaits: [{gaits}]\nprobes: [{probes}]\nlifted: [{lifted}]\n"


def read(tmp_path: Path, content: str | bytes) -> of_file.Motions:
    path = tmp_path / "menu.yaml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return load_motions(path)


def test_the_file_that_comes_with_snakebot_has_small_and_large_slow_and_fast_and_long() -> None:
    known = known_motions()
    for gaits in (known.start, known.gaits):
        assert min(gait.alpha_deg for gait in gaits) < 6 < 40 < max(gait.alpha_deg for gait in gaits)
        assert min(gait.omega_rad_s for gait in gaits) < 1 < 3 < max(gait.omega_rad_s for gait in gaits)
    assert any(gait.duration_s > DURATION_S for gait in known.gaits)
    assert any(gait.offset_deg for gait in known.gaits)
    for probes in (known.probes, known.lifted):
        assert {probe.kind for probe in probes} == {"triangle", "steps", "sine"}


def test_motions_are_read_in_their_order(tmp_path: Path) -> None:
    curved = "{alpha_deg: 50, beta_deg: 80, omega_rad_s: 2, offset_deg: 15, duration_s: 30}"
    found = read(tmp_path, text(gaits=f"{curved}, {GAIT}", lifted='"steps:amplitude_deg=20"'))
    assert found.start == (WrittenGait(4, 80, 0.5),)
    assert found.gaits == (WrittenGait(50, 80, 2, 15, 30), WrittenGait(4, 80, 0.5, 0, DURATION_S))
    assert found.probes == ()
    assert found.lifted == (parse_probe("steps:amplitude_deg=20"),)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("start: [", "line 2: not YAML: "),
        (b"\xff\xfe", "not UTF-8 text"),
        ("", "the motions are a mapping with start, gaits, probes, lifted"),
        ("[]", "the motions are a mapping with start, gaits, probes, lifted"),
        (text() + "probe: []\n", "line 5: probe is not known; did you mean probes?"),
        ("start: []\n", "line 1: start is empty; it takes a list of at least one gait"),
        (f"start: [{GAIT}]\n", "gaits is missing; it takes a list of motions, [] for none"),
        (f"start: [{GAIT}]\ngaits: 3\n", "line 2: gaits is no list; it takes a list of motions, [] for none"),
        (text(gaits="3"), "line 2: a gait is a mapping with alpha_deg, beta_deg, omega_rad_s"),
        (text(gaits="{alpha_deg: 4, beta_deg: 80}"), "line 2: omega_rad_s is missing"),
        (text(gaits=GAIT.replace("80", "true")), "line 2: beta_deg is True, not a number"),
        (text(gaits=GAIT.replace("0.5", ".nan")), "line 2: gait: omega_rad_s is nan; it must be a finite number"),
        (text(gaits=GAIT.replace("4", "-4")), "line 2: gait: alpha is -4 deg; an amplitude is zero or more"),
        (text(GAIT.replace("}", ", duration_s: 9}")), "line 1: duration_s is not known; a gait has "),
        (text(gaits=GAIT.replace("}", ", amplitudes: [1]}")), "line 2: amplitudes is not known; a gait has "),
        (text(gaits=GAIT.replace("}", ", duration_s: long}")), "line 2: duration_s is 'long', not 4 to 600 s"),
        (text(gaits=GAIT.replace("}", ", duration_s: 3}")), "line 2: duration_s is 3, not 4 to 600 s"),
        (text(gaits=GAIT.replace("}", ", duration_s: .nan}")), "line 2: duration_s is nan, not 4 to 600 s"),
        (text(probes="3"), "line 3: 3 is no probe; write it as after --probe"),
        (text(probes='"stairs:amplitude_deg=4"'), "line 3: --probe 'stairs:amplitude_deg=4': no such probe"),
        (text(lifted='"steps:amplitude_deg=x"'), "line 4: --probe steps: amplitude_deg=x is not a number"),
        (text(lifted='"steps:amplitude_deg=4,joints=3"'), "line 4: steps:amplitude_deg=4,joints=3: leave joints= out"),
    ],
)  # fmt: skip
def test_the_first_fault_is_told_in_a_line_that_names_the_file(
    content: str | bytes, said: str, tmp_path: Path
) -> None:
    with pytest.raises(BadInputError) as refused:
        read(tmp_path, content)
    told = str(refused.value)
    assert told.startswith(f"{tmp_path / 'menu.yaml'}: {said}")
    assert "\n" not in told


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"menu\.yaml: cannot read the motions: No such file"):
        load_motions(tmp_path / "menu.yaml")


def test_a_fault_is_told_before_anything_is_searched(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "motions").mkdir()
    (tmp_path / "motions" / "menu.yaml").write_text(text(probes='"stairs:amplitude_deg=4"'))
    monkeypatch.setattr(of_file, "configs_root", lambda: tmp_path)
    session = make_session(bench())
    known_motions.cache_clear()
    said: list[str] = []
    for ask in (
        lambda: diagnose(session, progress=lambda text, share: said.append(text)),
        lambda: plan(bench(), [], progress=lambda text, share: said.append(text)),
        lambda: missing(session),
    ):
        with pytest.raises(BadInputError, match=r"menu\.yaml: line 3: --probe 'stairs:amplitude_deg=4'"):
            ask()
    assert said == []
