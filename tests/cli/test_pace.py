"""Progress of a diagnosis: it never runs backwards, tells the time left by the pace of late, and what is known."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

import snakebot.diagnosis
from snakebot.cli.main import cli
from snakebot.cli.pace import Pace
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.trial import against_nominal
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.search import search


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_time_left_goes_by_the_pace_of_late() -> None:
    clock = Clock()
    pace = Pace(clock)
    for second in range(1, 11):
        clock.now = 100.0 + second
        pace.tell("trying rate_limit", 0.05 * second)
    assert pace.left_s() == pytest.approx(10, rel=0.01)
    assert (pace.text, pace.left_text) == ("trying a limit of speed", "about 10 s left")
    for second in range(11, 31):  # slower from here on
        clock.now = 100.0 + second
        pace.tell("", 0.5 + 0.01 * (second - 10))
    assert pace.left_s() == pytest.approx(30, rel=0.05)


def test_it_never_runs_backwards_and_says_nothing_before_it_knows() -> None:
    clock = Clock()
    pace = Pace(clock)
    pace.tell("reading the session", 0.0)
    assert pace.left_text == ""
    pace.tell("a", 0.4)
    pace.tell("b", 0.3)
    assert pace.share == 0.4


def test_the_search_tells_what_it_has_found() -> None:
    from sessions import bench, make_session

    evidence = gather(prepare(make_session(bench(2), ["rate_limit:limit_rad_s=1.2,joints=2"])))
    library = usable_effects(evidence.data, over_ground=False, known={}, only=["rate_limit"], exclude=())
    nominal, evidence = against_nominal(evidence)
    told: list[str] = []
    search(evidence, library, nominal, quick=True, progress=lambda text, share: told.append(text))
    assert "so far: rate_limit on joint 2" in told


def test_ctrl_c_says_what_is_known(tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    from sessions import bench, make_session

    def stopped(session: object, *, progress: object, **_: object) -> None:
        assert callable(progress)
        progress("so far: rate_limit on joint 3", 0.41)
        raise KeyboardInterrupt

    monkeypatch.setattr(snakebot.diagnosis, "diagnose", stopped)
    monkeypatch.setattr(
        "snakebot.cli.diagnose.given_session", lambda *_, **__: make_session(bench(1), gaits=((20, 80, 2.0),))
    )
    result = CliRunner().invoke(cli, ["diagnose", "somewhere"])
    assert (
        "stopped at 41 %; so far: a limit of speed on joint 3, not yet weighed against others"
        in result.output
    )
