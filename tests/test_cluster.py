"""One way to hand work out: sessions and gaits, here and on a cluster that loses a worker on the way."""

from __future__ import annotations

import logging
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from sessions import bench, make_session

from snakebot.cli.main import main
from snakebot.cluster import Workers
from snakebot.diagnosis.many import diagnose_many
from snakebot.errors import BadInputError, SnakebotError
from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.promise import OptimiseOptions
from snakebot.robot import load_robot
from snakebot.runlog import Session
from snakebot.runlog.session_write import write_session

ONLY = {"only": ("rate_limit",), "quick": True}


def sessions(count: int) -> dict[str, Session | BadInputError]:
    made: dict[str, Session | BadInputError] = {}
    for number in range(count):
        effects = [f"rate_limit:limit_rad_s={1.0 + 0.1 * number}"] if number % 2 else []
        made[f"s{number}"] = make_session(bench(1), effects)
    return made


def plain(answers: list[Any]) -> list[dict[str, Any]]:
    """Rows without what depends on the time of day or the computer's speed."""
    return [{key: value for key, value in one.row().items() if key != "json"} for one in answers]


@pytest.fixture
def cluster() -> Iterator[Any]:
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as made:
        yield made


def kill_a_worker(cluster: Any) -> None:
    """One that is alive: of a worker that was killed before, another process may not have begun yet."""
    nannies = [worker.process for worker in cluster.workers.values() if worker.process is not None]
    alive = [nanny.process for nanny in nannies if nanny.process is not None and nanny.process.is_alive()]
    alive[0].kill()


def test_pieces_are_done_here_in_their_order_and_each_once() -> None:
    with Workers() as workers:
        assert not workers.away
        assert list(workers.results(divmod, {"a": (7, 3), "b": (9, 2)})) == [("a", (2, 1)), ("b", (4, 1))]


@pytest.mark.slow
def test_a_scheduler_that_is_not_there_is_told() -> None:
    with pytest.raises(BadInputError, match="no scheduler answers"), Workers("tcp://127.0.0.1:1"):
        pass


def test_a_session_that_cannot_be_read_stops_no_other_and_nothing_is_sent_for_it() -> None:
    mixed = {"bad": BadInputError("bad: no runs"), **sessions(1)}
    told: list[tuple[int, int]] = []
    with Workers() as workers:
        answers = diagnose_many(mixed, ONLY, workers, lambda done, total: told.append((done, total)))
    assert [one.name for one in answers] == ["bad", "s0"]
    assert answers[0].row()["refused"] == "bad: no runs"
    assert answers[0].row()["json"] == ""
    assert answers[1].row()["verdict"] == "no_gap"
    assert told == [(2, 2)]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["x", "--dask", "tcp://127.0.0.1:1"], "only with --table"),
        (["x", "--table", "t.parquet", "--apply", "y.yaml"], "not with --table"),
        (["x", "x", "--table", "t.parquet"], "given twice"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    words: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["diagnose", *words])
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_table_is_written_over_and_nothing_else(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session = make_session(bench(1), duration_s=6.0)
    write_session(tmp_path / "s", session.robot, session.runs, "parquet")
    recording = next((tmp_path / "s").glob("*.parquet"))
    for sources, table, status in (
        (["s"], "t.parquet", 0),
        (["s"], "t.parquet", 0),
        (["no_such_session"], "t.parquet", 2),  # an earlier table is worth more than a row that says this
        (["s"], str(recording), 2),
    ):
        before = Path(table).read_bytes() if Path(table).exists() else b""
        with pytest.raises(SystemExit) as ended:
            main(["diagnose", *sources, "--table", table, "--quick", "--only", "rate_limit"])
        assert ended.value.code == status
        assert status == 0 or Path(table).read_bytes() == before
    assert "exists, and is no table" in capsys.readouterr().err


@pytest.mark.slow
def test_a_scheduler_without_workers_is_told_and_not_waited_for_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr("snakebot.cluster._WORKER_COMES_S", 0.5)
    with LocalCluster(n_workers=0, dashboard_address=None, processes=False, protocol="tcp://") as alone:
        address = alone.scheduler_address
        with pytest.raises(BadInputError, match=f"has no worker: start one, as by `dask worker {address}`"):
            Workers(address).__enter__()


SCHEDULER = """
import time
from distributed import LocalCluster
if __name__ == "__main__":
    made = LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, processes=False, protocol="tcp://"
    )
    print(made.scheduler_address, flush=True)
    time.sleep(600)
"""


@pytest.mark.slow
def test_a_scheduler_that_goes_away_is_one_line(tmp_path: Path) -> None:
    """Of another process, as at a lab: dask writes tracebacks of its own, and hands errors over as results."""
    script = tmp_path / "scheduler.py"
    script.write_text(SCHEDULER)
    there = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    try:
        assert there.stdout is not None
        address = there.stdout.readline().strip()
        level = logging.getLogger("distributed.client").level
        pieces = dict.fromkeys(range(50), (0.2,))
        with Workers(address) as workers, pytest.raises(SnakebotError, match="scheduler is gone") as told:
            for _, result in workers.results(time.sleep, pieces):
                assert result is None
                there.kill()
        assert "\n" not in str(told.value)
        assert logging.getLogger("distributed.client").level == level
    finally:
        there.kill()
        there.wait()
        if there.stdout is not None:
            there.stdout.close()


@pytest.mark.slow
def test_sessions_and_gaits_of_a_cluster_that_loses_a_worker(
    cluster: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is lost, nothing comes twice, and all is as it is here."""
    many = sessions(4)
    with Workers() as here:
        expected = plain(diagnose_many(many, ONLY, here))
    seen: list[int] = []

    def kill(done: int, total: int) -> None:
        seen.append(done)
        if done == 1:
            kill_a_worker(cluster)

    with Workers(cluster.scheduler_address) as away:
        found = diagnose_many(many, ONLY, away, kill)
    assert plain(found) == expected
    assert seen == [1, 2, 3, 4]

    robot = load_robot("penn_state").model_copy(update={"effects": ("rate_limit:limit_rad_s=1.2",)})
    options = OptimiseOptions(
        within={"alpha": (30, 40), "beta": (70, 80), "omega": (3, 4)}, draws=2, grid=(3, 3, 2), robust=True
    )
    alone = optimise(robot, Goal("speed"), options)
    counted, killed = [0], list[bool]()

    def kill_again(done: int) -> None:
        counted[0] += done
        if counted[0] > 10 and not killed:
            killed.append(True)
            kill_a_worker(cluster)

    with Workers(cluster.scheduler_address) as away:
        together = optimise(robot, Goal("speed"), options, progress=kill_again, workers=away)
    assert killed
    assert together.found == alone.found
    assert together.front == alone.front
    assert together.simulated == alone.simulated
    np.testing.assert_array_equal(together.seen, alone.seen)

    folders = []
    for name, session in list(many.items())[:2]:
        assert isinstance(session, Session)
        folders.append(str(write_session(tmp_path / name, session.robot, session.runs)))
    (tmp_path / "empty").mkdir()
    table = tmp_path / "all.parquet"
    words = ["--dask", cluster.scheduler_address, "--table", str(table), "--quick", "--only", "rate_limit"]
    with pytest.raises(SystemExit) as ended:
        main(["diagnose", *folders, str(tmp_path / "empty"), *words])
    assert ended.value.code == 2  # the empty one has no verdict
    rows = pq.read_table(table).to_pylist()
    assert [row["session"] for row in rows] == [*folders, str(tmp_path / "empty")]
    assert [bool(row["refused"]) for row in rows] == [False, False, True]
    assert rows[1]["causes"][0].startswith("rate_limit")
    assert "no verdict" in capsys.readouterr().out
