"""Parts of the page below the first screen: where each cause shows, speeds of runs, the tables."""

from __future__ import annotations

import pytest
from answers import KINDS, LIMIT, WEIGHT, made, trace
from sessions import bench, make_session, snake

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.result import Diagnosis, RankingEntry, RunEstimate, RunSpeed, RunValues
from snakebot.diagnosis.show.marks import speed_charts, trace_charts
from snakebot.diagnosis.show.page import page
from snakebot.diagnosis.show.tables import add_budget, add_by_run, add_ranking, add_stated
from snakebot.report import LineChart, Section, Table
from snakebot.runlog import Session


def rows_of(section: Section) -> list[list[str]]:
    table = next(block for block in section.blocks if isinstance(block, Table))
    return [[str(cell) for cell in row] for row in table.rows]


def with_ranking(found: Diagnosis, *entries: RankingEntry) -> Diagnosis:
    return found.model_copy(update={"ranking": entries})


def entry(*effects: str, left: float, parameters: int = 1) -> RankingEntry:
    return RankingEntry(
        effects=effects, joints=(), held_out_score=-1.0, delta=0.1, delta_se=0.1, probability=0.1,
        parameters=parameters, rms_after=left,
    )  # fmt: skip


def test_two_explanations_of_one_name_say_how_many_numbers_they_have() -> None:
    found = with_ranking(
        made("explained", WEIGHT),
        entry("ground_friction", left=0.01, parameters=4),
        entry("ground_friction", left=0.02),
        entry("slope", left=0.03),
    )
    section = Section("")
    add_ranking(section, found)
    names = [row[0] for row in rows_of(section)]
    assert names == [
        "another friction of the ground, 4 numbers fitted",
        "another friction of the ground, 1 number fitted",
        "ground that is not level",
    ]


def test_an_error_that_no_explanation_changes_is_no_column() -> None:
    section = Section("")
    add_ranking(section, with_ranking(made("explained", WEIGHT), entry("slope", left=0.01), entry(left=0.01)))
    assert len(rows_of(section)[0]) == 3


def test_every_number_of_the_description_is_in_the_table_of_stated_numbers() -> None:
    section = Section("")
    add_stated(section, KINDS["sure"](), snake())
    rows = {row[0]: row for row in rows_of(section)}
    assert rows["lag of the servo"][3] == "37.1 ms"
    assert rows["mass of a link"][2:4] == ["1.43 kg", "not told by these runs"]
    assert rows["half length of a link"][2:4] == ["0.0800 m", "taken as stated"]
    assert rows["counts of the encoder in a turn"][2] == "8192"


def test_a_bench_has_no_links_in_the_table() -> None:
    section = Section("")
    add_stated(section, KINDS["no gap"](), bench(1))
    assert {row[0] for row in rows_of(section)} == {"lag of the servo", "counts of the encoder in a turn"}


def test_the_error_of_one_of_several_causes_is_drawn_without_it_and_with_it() -> None:
    alone = trace(0)
    among = alone.model_copy(update={"others_rad": alone.before_rad})
    for one, name in ((alone, "now"), (among, "with all causes but this")):
        errors = trace_charts(one)[1]
        assert isinstance(errors, LineChart)
        assert [line.name for line in errors.lines] == [name, "with it"]


def test_a_cause_over_ground_has_the_speeds_of_the_runs_beside_it() -> None:
    found = made("explained", WEIGHT)
    assert found.details is not None
    speeds = (RunSpeed(run="run_07.csv", measured=0.1, before=0.2, after=0.101),)
    details = found.details.model_copy(update={"speeds": speeds})
    html = page(Session(snake(), ()), found.model_copy(update={"details": details}))
    assert "Forward speed by run" in html
    assert "run_07.csv" in html
    assert len(speed_charts(speeds)) == 2
    assert "Forward speed by run" not in page(Session(snake(), ()), made("explained", LIMIT))


@pytest.mark.slow
def test_a_small_cause_beside_a_large_one_is_shown_where_it_carries_the_gap() -> None:
    effects = ("rate_limit:limit_rad_s=1.3", "backlash:width_deg=6,joints=1")
    found = diagnose(make_session(bench(2), effects), quick=True)
    assert {cause.effect for cause in found.causes} == {"rate_limit", "backlash"}
    assert found.details is not None
    shown = {found.causes[t.cause].effect: t for t in found.details.traces if t.cause is not None}
    assert shown["backlash"].joint == 1
    assert shown["backlash"].run == "run_03.csv"  # 0.87 rad/s at most: the limit is not met there
    assert len(shown["backlash"].others_rad) == len(shown["backlash"].t_s)


def test_a_share_of_next_to_nothing_has_no_sign() -> None:
    section = Section("shares")
    found = made("explained", LIMIT)
    (share,) = found.budget
    carries = share.model_copy(update={"share": 1.0, "by_joint": (-0.001, None, 0.996)})
    rest = carries.model_copy(update={"cause": None, "share": 0.0, "by_joint": (1.001, None, 0.004)})
    add_budget(section, found.model_copy(update={"budget": (carries,), "budget_rest": (rest,)}))
    by_joint = {row[0]: row[1:] for row in rows_of(section) if row[0].startswith("joint")}
    assert by_joint == {"joint 1": ["0", "100"], "joint 2": ["no gap", "no gap"], "joint 3": ["100", "0"]}


@pytest.mark.parametrize(
    ("effect", "value"), [("rate_limit", "1.20 rad/s"), ("of_another_package", "1.20 rad/s")]
)
def test_what_differs_from_run_to_run_is_a_table(effect: str, value: str) -> None:
    found = made("explained", LIMIT)
    values = RunValues(
        effect=effect,
        parameter="limit_rad_s",
        unit="rad/s",
        joints=(1,),
        values=(
            RunEstimate(run="one.csv", estimate=1.2, ci95=(1.1, 1.3)),
            RunEstimate(run="two.csv", estimate=0.8, ci95=None),
        ),
        unlike=("two.csv",),
        of_rest=0.9,
    )
    section = Section("")
    add_by_run(section, found.model_copy(update={"where": found.where.model_copy(update={"values": values})}))
    first, second = rows_of(section)
    assert first[:2] == ["one.csv", value]
    assert second[0] == "two.csv"
    assert second[2:] == ["", "unlike the others"]


def test_nothing_that_differs_from_run_to_run_is_no_table() -> None:
    section = Section("")
    add_by_run(section, made("explained", LIMIT))
    assert not section.blocks
