"""The first screen of the page: the answer, where it sits on the robot, how far the error falls, what to do."""

from __future__ import annotations

from math import degrees

from snakebot.diagnosis.result import Diagnosis
from snakebot.diagnosis.show import answer, certainty
from snakebot.diagnosis.show.named import effect_of, joint_count, share_in_words, stages_in_words, values_of
from snakebot.diagnosis.show.words import VERDICTS
from snakebot.diagnosis.sizes import NO_PERCENT
from snakebot.effects.telling import joints_in_words
from snakebot.in_words import three
from snakebot.report import Answer, Drawing, Fall, ToDo

TONES = {"explained": "found", "partly": "found", "no_gap": "good", "unexplained": "open"}


def first_screen(found: Diagnosis, *, body: bool) -> Answer:
    """``body``: the robot is a snake, and not joints on a bench."""
    said = certainty.word(found)
    stage = "" if found.verdict == "no_gap" else f", {stages_in_words(found)}"
    why = certainty.why(found)
    return Answer(
        verdict=f"{VERDICTS[found.verdict]}{f' ({said})' if said else ''}{stage}",
        tone=TONES[found.verdict],
        sentence=answer.sentence(found),
        sure=said[:1].upper() + said[1:],
        why=f"{why}." if why else "",
        drawing=drawing(found, body=body),
        fall=_fall(found),
        todo=[ToDo(one.where, one.text.replace("`", ""), one.command) for one in answer.advice(found)],
    )


def drawing(found: Diagnosis, *, body: bool) -> Drawing:
    """The robot, with the joints and links that the answer speaks of marked, and what each joint carries of the gap."""
    shares = found.where.joint_shares if found.verdict != "no_gap" else (0.0,) * joint_count(found)
    marked = () if found.verdict == "no_gap" else found.where.joints
    links: list[int] = []
    for cause in found.causes if found.verdict in ("explained", "partly") else ():
        effect = effect_of(cause)
        named = effect.shown_on(values_of(cause)) if effect is not None else ()
        links += named or (range(1, len(shares) + 2) if body and cause.stage == "body" else ())
    parts = [f"joint {j} carries {s:.0%}" for j, s in enumerate(shares, start=1) if s >= NO_PERCENT]
    on = f"{joints_in_words(marked, len(shares))} marked; " if marked else "no joint marked; "
    return Drawing(
        shares, marked, links, body, on + (", ".join(parts) + " of the gap" if parts else "no gap")
    )


def _fall(found: Diagnosis) -> Fall | None:
    """One error before and after: of the joint angles where they have a gap, else of the forward speed."""
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    explained = bool(found.causes) and found.verdict != "no_gap"
    name = {"unexplained": "nearest"}.get(found.verdict, "with it") if explained else ""
    if answer.over_ground(found) and speed is not None:
        return Fall(
            "Error of the forward speed",
            speed.error_before,
            speed.error_after,
            speed.floor,
            _texts(speed.error_before, speed.error_after, speed.floor, "m/s"),
            name,
            f"{share_in_words(speed.closed)} of the gap closed"
            if explained and speed.closed is not None
            else "",
        )
    before, after = degrees(angle.rms_before), degrees(angle.rms_after)
    floor = None if angle.rms_floor is None else degrees(angle.rms_floor)
    closed = (
        "" if angle.closed is None or not explained else f"{share_in_words(angle.closed)} of the gap closed"
    )
    return Fall(
        "Error of joint angles",
        before,
        after,
        floor,
        _texts(before, after, floor, "deg"),
        name,
        closed,
    )


def _texts(before: float, after: float, floor: float | None, unit: str) -> tuple[str, str, str]:
    noise = "not known" if floor is None else f"{three(floor)} {unit}"
    return f"{three(before)} {unit}", f"{three(after)} {unit}", noise
