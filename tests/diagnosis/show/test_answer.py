"""The answer in plain words, for every kind of verdict; and the words on a terminal."""

from __future__ import annotations

import re

import pytest
from answers import KINDS, LIMIT, NEXT, SCALE, made

from snakebot.diagnosis.result import BudgetEntry, Diagnosis, JointClosure, SpeedClosure
from snakebot.diagnosis.show.answer import advice, sentence, with_words
from snakebot.diagnosis.show.certainty import why, word
from snakebot.diagnosis.show.first_screen import first_screen
from snakebot.diagnosis.show.named import parameter_rows, plain, stages_in_words
from snakebot.diagnosis.show.tables import why_it_lost
from snakebot.diagnosis.show.words import summary
from snakebot.effects.registry import LIBRARY

FALLS = (
    "With that in the simulation, the error on runs it was not fitted to falls from 0.819 to 0.0129 deg: "
    "all of the gap."
)


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("sure", f"Joint 3 cannot turn faster than 2.00 rad/s. {FALLS}"),
        (
            "two causes that tie",
            "Joint 3 cannot turn faster than 2.00 rad/s; either joint 1 turns 0.900 times the angle that it is told, "
            f"or it is an encoder of wrong scale: these runs cannot tell. {FALLS}",
        ),
        ("likely", f"Probably joint 3 cannot turn faster than 2.00 rad/s. {FALLS}"),
        ("a guess", f"Perhaps joint 3 cannot turn faster than 2.00 rad/s. {FALLS}"),
        (
            "one motion",
            "Perhaps joint 3 cannot turn faster than 2.00 rad/s. With that in the simulation, the error on the runs it "
            "was fitted to falls from 0.819 to 0.0129 deg.",
        ),
        (
            "partly",
            "Joint 3 cannot turn faster than 2.00 rad/s. With that in the simulation, the error on runs it was not "
            "fitted to falls from 0.819 to 0.504 deg: 62 % of the gap. The other 38 % no known effect explains.",
        ),
        (
            "over ground",
            "Link 5 carries 0.512 kg more than stated. With that in the simulation, the error of the forward speed on "
            "runs it was not fitted to falls from 0.0612 to 0.00757 m/s: 97 % of the gap.",
        ),
        (
            "unexplained",
            "Joint 3 does something that no known effect explains: the simulation is 0.819 deg off, 0.0120 deg would "
            "be noise. The nearest, a limit of speed, takes away 12 % of the gap.",
        ),
        (
            "no gap",
            "The robot does what the simulation says: joint angles are 0.819 deg off, no more than noise and the "
            "tolerance of the stated numbers allow.",
        ),
    ],
)
def test_every_verdict_has_its_sentence(kind: str, said: str) -> None:
    assert sentence(KINDS[kind]()) == said


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_said_without_code_and_in_few_lines(kind: str) -> None:
    found = KINDS[kind]()
    lines = summary(found)
    assert 3 <= len(lines) <= 15
    prose = [line for line in lines if "snakebot run" not in line]
    for line in prose:
        assert not any(re.search(rf"\b{name}\b", line) for name in LIBRARY), line
        assert not re.search(r"\d\.\d{6,}|rad_s|closed=|None|nan", line), line
    assert "%" not in sentence(found) or "103" not in sentence(found)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_says_what_to_do(kind: str) -> None:
    found = KINDS[kind]()
    assert advice(found)
    told = with_words(found)
    assert told.sentence == sentence(found)
    assert all(one.text in told.advice for one in advice(found))


def test_an_error_that_stays_is_not_said_to_fall() -> None:
    said = sentence(made("explained", LIMIT, closed=0.0))
    assert "does not shrink with it" in said
    assert "falls" not in said


def test_what_the_stated_numbers_are_off_by_is_told_where_it_is_most_of_the_rest() -> None:
    found = KINDS["sure"]()
    angle = found.closure.joint_angle.model_copy(
        update={
            "rms_before": 0.0045, "rms_after": 0.0043, "rms_before_within_tolerance": 0.0021,
            "rms_within_tolerance": 0.0013, "rms_floor": 0.0007, "closed": 0.09,
        }
    )  # fmt: skip

    def said(**changed: float) -> str:
        closure = found.closure.model_copy(update={"joint_angle": angle.model_copy(update=changed)})
        return sentence(found.model_copy(update={"closure": closure}))

    assert (
        "within their tolerance: with the lags that these runs tell, it falls from 0.120 to 0.0745 deg"
        in said()
    )
    assert "tolerance" not in said(rms_within_tolerance=0.004)  # little of the rest
    assert "tolerance" not in said(closed=0.95)  # nobody asks for it


def test_one_explanation_is_told_as_one() -> None:
    found = made("unexplained", closed=0.1, left=0.9)
    assert why(found) == "One explanation was tried on runs it was not fitted to, and does not hold"


def test_a_tie_is_never_called_sure_and_its_stages_are_both() -> None:
    found = KINDS["two causes that tie"]()
    assert word(found) == "a tie"
    assert stages_in_words(found) == "servo or sensor"
    where = with_words(found).to_mapping()["where"]
    assert (where["stage"], where["stages"]) == (found.where.stage, ["servo", "sensor"])
    assert where["stages_in_words"] == "servo or sensor"
    assert why(found) == "These runs cannot tell a wrong scale of the motion from an encoder of wrong scale"
    assert "servo or sensor" in first_screen(found, body=True).verdict
    (run,) = [one for one in advice(found) if one.command == NEXT.command]
    assert "tells a wrong scale of the motion from an encoder of wrong scale" in run.text


def test_why_it_is_sure() -> None:
    said = why(KINDS["sure"]())
    assert said == (
        "The next best explanation, another servo lag, joint 3, fails in 2 of 3 runs; "
        "about 97 of 100 such answers are right"
    )


def test_a_slow_log_and_a_single_motion_say_what_they_cost() -> None:
    assert "set-points between its rows had to be guessed" in why(KINDS["slow log"]())
    assert "One motion alone" in why(KINDS["one motion"]())


def test_what_no_motion_tells_apart_says_what_would() -> None:
    tie = "no motion separates command_gain, encoder_gain on these channels; a protractor would"
    found = made("explained", SCALE, warnings=(tie,))
    assert "No motion of this robot tells them apart; a protractor would." in [
        one.text for one in advice(found)
    ]
    assert plain(tie).startswith("no motion separates a wrong scale of the motion, an encoder of wrong scale")


def test_the_line_that_puts_it_into_the_simulation_is_short() -> None:
    (simulate,) = [one for one in advice(KINDS["sure"]()) if one.where == "Simulation"]
    assert (
        simulate.command
        == "snakebot run --alpha 66 --beta 80 --omega 2 --effect rate_limit:limit_rad_s=2,joints=3"
    )


def test_commands_for_another_robot_name_its_description() -> None:
    found = KINDS["two causes that tie"]()
    assert found.details is not None
    assert found.next_experiment is not None
    option = {"robot_option": " --robot ROBOT.yaml"}
    other = found.model_copy(update={"details": found.details.model_copy(update=option)})
    told = {one.where: one for one in advice(other)}
    assert told["Next run"].command == f"{found.next_experiment.command} --robot ROBOT.yaml"
    assert told["Simulation"].command.endswith("command_gain:gain=0.9001,joints=1 --robot ROBOT.yaml")
    assert not any("--robot" in one.command for one in advice(found))


def test_numbers_have_three_digits_units_and_names_in_words() -> None:
    assert parameter_rows(LIMIT) == [("fastest turn", "2.00 rad/s", "1.98 to 2.02 rad/s")]


def test_why_each_explanation_lost() -> None:
    found = KINDS["sure"]()
    best, lag, nothing = found.ranking
    assert why_it_lost(found, best, best) == "named"
    assert why_it_lost(found, lag, best) == "fails in 2 of 3 runs: run_01.csv, run_02.csv"
    assert why_it_lost(found, nothing, best) == "there is a gap"
    more = best.model_copy(
        update={"effects": ("voltage_sag",), "delta": 0.001, "delta_se": 0.01, "parameters": 2}
    )
    assert why_it_lost(found, more, best) == "no better, with 1 more number to fit"


def test_the_drawing_marks_the_joint_and_the_link() -> None:
    svg = first_screen(KINDS["sure"](), body=True).drawing.svg()
    assert svg.count('class="ring"') == 1
    assert "96 %" in svg
    assert 'class="link marked"' in first_screen(KINDS["over ground"](), body=True).drawing.svg()
    bench = first_screen(KINDS["sure"](), body=False).drawing.svg()
    assert bench.count('class="servo"') == 5
    assert "ring" not in first_screen(KINDS["no gap"](), body=True).drawing.svg()


def test_it_is_the_tie_alone_that_runs_cannot_tell() -> None:
    assert sentence(made("explained", SCALE, LIMIT)).startswith(
        "Either joint 1 turns 0.900 times the angle that it is told, or it is an encoder of wrong scale (these runs "
        "cannot tell); joint 3 cannot turn faster than 2.00 rad/s. With"
    )


def test_a_tie_on_a_slow_log_says_both() -> None:
    found = made("explained", SCALE.model_copy(update={"probability": 0.7}), slow=True)
    assert word(found) == "a tie"
    assert why(found).endswith("; the log is slow, too")


@pytest.mark.parametrize(
    ("error_m_s", "floor_m_s", "told"),
    [(0.03, 0.002, True), (0.03, 0.016, False), (0.009, 0.002, False)],
)
def test_a_speed_that_is_off_within_what_is_allowed_is_told_where_there_is_no_gap(
    error_m_s: float, floor_m_s: float, told: bool
) -> None:
    """Of 0.2 m/s: more than noise, and more than next to nothing."""
    found = KINDS["no gap"]()
    speed = SpeedClosure(
        error_before=error_m_s, error_after=error_m_s, rms_measured=0.2, floor=floor_m_s, closed=None
    )
    found = found.model_copy(update={"closure": found.closure.model_copy(update={"forward_speed": speed})})
    assert ("Its forward speed is 0.0300 m/s off, 15 % of it." in sentence(found)) is told
    assert any("--rate" in one.text for one in advice(found)) is told
    assert any("for joint angles" in one.text for one in advice(found)) is told


def test_where_little_falls_in_all_it_is_told_of_the_joints_of_the_cause() -> None:
    found = made("explained", LIMIT, closed=0.3)
    rows = tuple(
        JointClosure(joint=j, rms_before=0.01 if j == 3 else 0.005, rms_after=0.001 if j == 3 else 0.005, rms_floor=0.0)
        for j in range(1, 6)
    )  # fmt: skip
    told = "On joint 3 it falls from 0.573 to 0.0573 deg."

    def said(closed: float, by_joint: tuple[JointClosure, ...]) -> str:
        angle = found.closure.joint_angle.model_copy(update={"closed": closed})
        closure = found.closure.model_copy(update={"joint_angle": angle, "by_joint": by_joint})
        return sentence(found.model_copy(update={"closure": closure}))

    assert told in said(0.3, rows)
    assert told not in said(0.9, rows)  # said of all of them
    assert "On joint 3" not in said(0.3, rows[2:3])  # there is no other


def test_a_cause_of_next_to_no_probability_is_counted_and_not_told() -> None:
    """Clocks that drift, at 1 %, were told in the first sentence beside what closes the gap."""
    found = made("explained", SCALE, LIMIT.model_copy(update={"probability": 0.01}))
    said = sentence(found)
    assert (
        "joint 1 turns 0.900 times the angle that it is told, or it is an encoder of wrong scale (these"
        in said
    )
    assert "(and 1 more)" in said
    assert "cannot turn faster" not in said
    alone = made("explained", LIMIT.model_copy(update={"probability": 0.01}))
    assert "cannot turn faster" in sentence(alone)


def test_a_cause_that_carries_next_to_nothing_makes_no_guess_of_the_others() -> None:
    """Lost set-points of 0.12 beside a loop that closes 95 % of the gap made a guess of the loop."""
    small = LIMIT.model_copy(update={"probability": 0.12})
    found = made("explained", SCALE.model_copy(update={"indistinguishable_from": ()}), small)

    def carrying(share: float, by_joint: tuple[float | None, ...]) -> Diagnosis:
        entries = ((0, 1 - share, (1.0, None, None)), (1, share, by_joint))
        budget = tuple(
            BudgetEntry(cause=place, of="joint_angle", share=part, ci95=None, by_joint=joints)
            for place, part, joints in entries
        )
        return found.model_copy(update={"budget": budget})

    little = carrying(0.02, (0.02, None, None))
    assert word(little) == "sure"
    assert "cannot turn faster" not in sentence(little)
    assert "(and 1 more)" in sentence(little)
    for much in (carrying(0.3, (0.3, None, None)), carrying(0.02, (0.0, None, 0.9))):
        assert word(much) == "a guess"
        assert "cannot turn faster" in sentence(much)
