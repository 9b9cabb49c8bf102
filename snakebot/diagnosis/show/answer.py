"""The answer: one plain sentence, and what to do now."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from snakebot.diagnosis.result import AngleClosure, Cause, Diagnosis
from snakebot.diagnosis.show import certainty
from snakebot.diagnosis.show.named import (
    cause_sentence,
    effect_of,
    effect_title,
    in_degrees,
    joint_count,
    share_in_words,
    short_specification,
    stages,
    stages_in_words,
)
from snakebot.diagnosis.sizes import HALF, LITTLE, MOST_TOLD, NEXT_TO_NOTHING
from snakebot.effects.telling import joints_in_words
from snakebot.in_words import listed, three

SOME_GAIT = "--alpha 66 --beta 80 --omega 2"  # to see effects in simulation: the example of the README
ROBOT, RUN, SIMULATION = "On the robot", "Next run", "Simulation"


@dataclass(frozen=True)
class Advice:
    """Something to do: where, what, and perhaps the command that does it."""

    where: str
    text: str
    command: str = ""


def sentence(found: Diagnosis) -> str:
    """The whole answer in one or two plain sentences."""
    return " ".join((statement(found), *effect_on_error(found))).strip()


def statement(found: Diagnosis, *, hedged: bool = True) -> str:
    """What is the matter with the robot; ``hedged`` says "probably" or "perhaps" where it is not sure."""
    count = joint_count(found)
    if found.verdict == "no_gap":
        return _no_gap(found)
    if found.verdict == "unexplained":
        return _unexplained(found, count)
    causes = certainty.credible(found)
    parts = [_with_rivals(cause, count) for cause in causes[:MOST_TOLD]]
    more = len(found.causes) - len(parts)
    ties = [bool(cause.indistinguishable_from) for cause in causes]
    # said of the tie alone, where something comes after it
    apart = any(ties[:-1]) or (more > 0 and any(ties))
    if apart:
        parts = [
            f"{part} (these runs cannot tell)" if tie else part
            for part, tie in zip(parts, ties, strict=False)
        ]
    text = "; ".join([parts[0], *(_inside(part) for part in parts[1:])])
    text += f" (and {more} more)" if more > 0 else ""
    said = certainty.word(found)
    if any(ties):
        text += "" if apart else ": these runs cannot tell"
    elif said == "a tie":
        text += ", or it is another explanation that fits as well"
    start = {"likely": "Probably ", "a guess": "Perhaps "}.get(said, "") if hedged else ""
    return f"{start}{_inside(text) if start else text}."


def _with_rivals(cause: Cause, count: int) -> str:
    """What is said of a cause; of one that ties, with those that it ties with."""
    said = cause_sentence(cause, count)
    rivals = dict.fromkeys(effect_title(name) for name in cause.indistinguishable_from)
    return f"Either {_inside(said)}, or it is {listed(list(rivals), 'or')}" if rivals else said


def effect_on_error(found: Diagnosis) -> list[str]:
    """How far the error shrinks with it in the simulation, and what is left."""
    if found.verdict in ("no_gap", "unexplained") or not found.causes:
        return []
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    known = [effect_of(cause) for cause in found.causes]
    if angle.closed is None and all(effect is not None and "scatter" in effect.shows_in for effect in known):
        return ["It shows in how the readings scatter; in the mean they are as predicted."]
    held = "runs it was not fitted to" if found.closure.held_out_runs else "the runs it was fitted to"
    if over_ground(found) and speed is not None:
        fall = f"from {three(speed.error_before)} to {three(speed.error_after)} m/s"
        what, share = "error of the forward speed", speed.closed
    else:
        fall = f"from {in_degrees(angle.rms_before)} to {in_degrees(angle.rms_after)} deg"
        what, share = "error", angle.closed
    closed = f": {share_in_words(share)} of the gap" if share is not None else ""
    if share is not None and share_in_words(share) == "none":
        lines = [f"The {what} on {held} does not shrink with it ({fall}{closed})."]
    else:
        lines = [f"With that in the simulation, the {what} on {held} falls {fall}{closed}."]
    if over_ground(found) and found.closure.ground is not None and (share is None or share < HALF):
        told = share_in_words(found.closure.ground.closed)
        lines.append(
            f"Within a cycle, sideways and turning too, it closes {told} of the gap beyond tolerance."
        )
    if not over_ground(found):
        lines += [line for line in (_on_its_joints(found), _tolerated(angle)) if line is not None]
    if found.verdict == "partly":
        lines.append(f"The other {100 * found.unexplained.share:.0f} % no known effect explains.")
    return lines


def _on_its_joints(found: Diagnosis) -> str | None:
    """How far the error falls on the joints of the causes, where it falls little on all together; None elsewhere."""
    closed = found.closure.joint_angle.closed
    joints = {joint for cause in found.causes for joint in cause.joints}
    rows = [row for row in found.closure.by_joint if row.joint in joints]
    if closed is None or closed >= HALF or not rows or len(rows) == len(found.closure.by_joint):
        return None
    before, after = (
        sqrt(sum(value**2 for value in values) / len(rows))
        for values in ([row.rms_before for row in rows], [row.rms_after for row in rows])
    )
    on = joints_in_words(tuple(sorted(joints)), joint_count(found))
    return f"On {on} it falls from {in_degrees(before)} to {in_degrees(after)} deg."


def _tolerated(angle: AngleClosure) -> str | None:
    """That most of what is left is what the stated numbers may be off by; None where it is not, or is little."""
    within, floor = angle.rms_within_tolerance, angle.rms_floor or 0.0
    before = angle.rms_before_within_tolerance
    if within is None or before is None or (angle.closed is not None and angle.closed > 1 - LITTLE):
        return None
    if angle.rms_after**2 - within**2 < HALF * (angle.rms_after**2 - floor**2):
        return None
    return (
        "Most of the rest is what the stated numbers are off by, within their tolerance: with the lags that these runs "
        f"tell, it falls from {in_degrees(before)} to {in_degrees(within)} deg."
    )


def over_ground(found: Diagnosis) -> bool:
    """Whether the forward speed is what is explained: the joint angles have no gap."""
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    if angle.closed is not None or speed is None:
        return False
    return speed.closed is not None or any(cause.stage == "body" for cause in found.causes)


def _no_gap(found: Diagnosis) -> str:
    off = in_degrees(found.closure.joint_angle.rms_before)
    text = (
        f"The robot does what the simulation says: joint angles are {off} deg off, no more than noise and the "
        "tolerance of the stated numbers allow."
    )
    off_m_s, share = _allowed_speed_error(found)
    if not share:
        return text
    return (
        f"{text} Its forward speed is {three(off_m_s)} m/s off, {share_in_words(share)} of it. Friction and mass "
        "within their tolerance, and servos that ripple between set-points, may do that: these runs cannot tell."
    )


def _allowed_speed_error(found: Diagnosis) -> tuple[float, float]:
    """Error of the forward speed (m/s) where there is no gap, and its share of the speed: none that is noise, or next
    to nothing.
    """
    speed = found.closure.forward_speed
    if speed is None or not speed.rms_measured or (speed.floor or 0.0) >= HALF * speed.error_before:
        return 0.0, 0.0
    share = speed.error_before / speed.rms_measured
    return (speed.error_before, share) if share > NEXT_TO_NOTHING else (0.0, 0.0)


def _unexplained(found: Diagnosis, count: int) -> str:
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    if found.where.joints and found.where.stage != "body":
        on = joints_in_words(found.where.joints, count)
        floor = "" if angle.rms_floor is None else f", {in_degrees(angle.rms_floor)} deg would be noise"
        what = (
            f"{on} {'do' if len(found.where.joints) != 1 else 'does'} something that no known effect explains"
        )
        text = (
            f"{what[0].upper()}{what[1:]}: the simulation is {in_degrees(angle.rms_before)} deg off{floor}."
        )
    elif speed is not None:
        off = three(speed.error_before)
        text = f"The robot moves over ground as no known effect explains: its forward speed is {off} m/s off."
    else:
        text = "Robot and simulation part, and no known effect explains it."
    if found.causes and angle.closed is not None:
        best = effect_title(found.causes[0].effect)
        text += f" The nearest, {best}, takes away {share_in_words(angle.closed)} of the gap."
    return text


def of_this_robot(command: str, found: Diagnosis) -> str:
    """A command of `snakebot run`, for the session's robot."""
    return command + (found.details.robot_option if found.details is not None else "")


def advice(found: Diagnosis) -> list[Advice]:
    """What to look at on the robot, which one run to make, what puts it into the simulation."""
    out: list[Advice] = []
    count, run = joint_count(found), found.next_experiment
    if found.verdict == "no_gap":
        _, share_off = _allowed_speed_error(found)
        if share_off:
            tip = (
                "Set-points sent more often (`--rate`) leave servos less to ripple, and friction and mass that are "
                "measured, with a tighter `tolerance:`, account for less: a slope or a drag shows then."
            )
            out.append(Advice(RUN, tip))
        what = "Use it as it is for joint angles." if share_off else "Use it as it is."
        more = "Smaller effects show with a repeated run and tighter `tolerance:`."
        return [*out, Advice(SIMULATION, f"{what} {more}")]
    if found.verdict == "unexplained":
        at = joints_in_words(found.where.joints, count) if found.where.joints else "the robot"
        out.append(Advice(ROBOT, f"Watch {at}: {found.where.regime}."))
        if run is None:
            tip = (
                "Record a slow small motion, a fast one and one repeat, with a row for every set-point; "
                "see docs/diagnosis.md."
            )
            out.append(Advice(RUN, tip))
    else:
        out += [
            Advice(ROBOT, _look(cause, found))
            for cause in certainty.credible(found)[:MOST_TOLD]
            if _look(cause, found)
        ]
    if run is not None:
        lifted = " with the robot lifted off the ground" if run.lifted else ""
        told = listed([" from ".join(effect_title(n) for n in pair) for pair in run.separates])
        settles = f" It tells {told}." if run.separates else ""
        out.append(
            Advice(RUN, f"One more{lifted}: {run.motion}.{settles}", of_this_robot(run.command, found))
        )
    elif found.verdict != "unexplained" and certainty.word(found) in ("a tie", "a guess"):
        hints = [w.partition("; ")[2] for w in found.warnings if w.startswith("no motion separates")]
        out += [
            Advice(RUN, f"No motion of this robot tells them apart; {hint}.") for hint in hints[:1] if hint
        ]
    if found.verdict in ("explained", "partly") and found.causes:
        effects = " ".join(f"--effect {short_specification(cause)}" for cause in found.causes)
        out.append(
            Advice(
                SIMULATION,
                "`--apply FILE` writes it into the description of the robot; in one run:",
                of_this_robot(f"snakebot run {SOME_GAIT} {effects}", found),
            )
        )
    return out


def _look(cause: Cause, found: Diagnosis) -> str:
    """What to look at; of several causes, where."""
    effect = effect_of(cause)
    if (
        effect is None
        or not effect.look
        or len(found.causes) == 1
        or not cause.joints
        or cause.stage == "body"
    ):
        return effect.look if effect is not None else ""
    on = joints_in_words(cause.joints, joint_count(found))
    return f"{on[0].upper()}{on[1:]}: {_inside(effect.look)}"


def advice_in_one(found: Diagnosis) -> str:
    """The same as one text."""
    return " ".join(
        f"{one.where}: {one.text}" + (f" `{one.command}`" if one.command else "") for one in advice(found)
    )


def with_words(found: Diagnosis) -> Diagnosis:
    """The same with the answer, the advice and the stages of what ties in it."""
    where = found.where.model_copy(
        update={"stages": stages(found), "stages_in_words": stages_in_words(found)}
    )
    return found.model_copy(
        update={"sentence": sentence(found), "advice": advice_in_one(found), "where": where}
    )


def _inside(text: str) -> str:
    """In the form that it has within a sentence."""
    return text[0].lower() + text[1:]
