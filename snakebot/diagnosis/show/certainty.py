"""How sure an answer is, in one word, and why."""

from __future__ import annotations

from collections.abc import Sequence

from snakebot.diagnosis.result import Cause, Diagnosis, RankingEntry
from snakebot.diagnosis.show.named import effect_title, explanation, joint_count, runs_in_words
from snakebot.diagnosis.sizes import HALF, LIKELY, NEXT_TO_NOTHING, SURE
from snakebot.in_words import listed


def credible(found: Diagnosis) -> Sequence[Cause]:
    """The causes without those of next to no probability, which only help the others to fit; all, if none is left."""
    return [cause for cause in found.causes if cause.probability > NEXT_TO_NOTHING] or found.causes


def least_probability(found: Diagnosis) -> float:
    """Of the causes that are told."""
    return min((cause.probability for cause in credible(found)), default=0.0)


def tied(found: Diagnosis) -> bool:
    """Whether another explanation is as good, or more than half as likely: a cause's probability is then that of a
    group, not of the one named.
    """
    if any(cause.indistinguishable_from or cause.evidence.get("rivals", 0) > 0 for cause in found.causes):
        return True
    best = sorted((entry.probability for entry in found.ranking), reverse=True)[:2]
    return len(best) == 2 and best[1] > HALF * best[0]


def word(found: Diagnosis) -> str:
    """ "sure", "likely", "a guess" or "a tie"; of a robot without a gap, or with one that nothing explains: ""."""
    if found.verdict in ("no_gap", "unexplained"):
        return ""
    least = least_probability(found)
    if least < LIKELY:
        return "a guess"
    return "a tie" if tied(found) else "sure" if least >= SURE else "likely"


def why(found: Diagnosis) -> str:
    """One sentence on what the word rests on."""
    said = word(found)
    runs = len(found.closure.held_out_runs)
    if found.verdict == "no_gap":
        doubt = (
            ""
            if found.closure.joint_angle.rms_floor is not None
            else "; no repeated run says how large noise is"
        )
        return f"Every joint and run was compared{doubt}"
    if found.verdict == "unexplained":
        tried = len({entry.effects for entry in found.ranking if entry.effects})
        if tried == 1:
            return "One explanation was tried on runs it was not fitted to, and does not hold"
        return f"{tried} explanations were tried on runs they were not fitted to, none does" if tried else ""
    slow = found.details is not None and found.details.slow_log
    if said == "a tie":
        return tie_sentence(found) + ("; the log is slow, too" if slow else "")
    limits = []
    if slow:
        limits.append("the log is slow: set-points between its rows had to be guessed")
    if not runs:
        limits.append("one motion alone was recorded or shows it, so that nothing could be tested on another")
    if said == "a guess" and tied(found):
        limits.append(tie_sentence(found)[0].lower() + tie_sentence(found)[1:])
    if any("bend" in cause.evidence for cause in found.causes):
        limits.append("what is left bends with the angle, and what is named is straight")
    if any("share_of_named" in cause.evidence for cause in found.causes):
        limits.append("an effect that would look the same may not be named")
    if found.verdict == "partly":
        limits.append("a part of the gap follows another law")
    if limits:
        return listed(limits)[0].upper() + listed(limits)[1:]
    rival = next_best(found)
    chance = f"about {100 * least_probability(found):.0f} of 100 such answers are right"
    if rival is None:
        return chance[0].upper() + chance[1:]
    fails = f"fails in {runs_in_words(rival.worse_in, runs)}"
    return f"The next best explanation, {explanation(rival, joint_count(found))}, {fails}; {chance}"


def next_best(found: Diagnosis) -> RankingEntry | None:
    """The best of the explanations that clearly lose somewhere; none where that is not known."""
    return next((entry for entry in found.ranking if entry.worse_in and entry.effects), None)


def tie_sentence(found: Diagnosis) -> str:
    """Which explanations tie."""
    named = next((cause for cause in found.causes if cause.indistinguishable_from), None)
    if named is not None:
        names = dict.fromkeys(effect_title(n) for n in (named.effect, *named.indistinguishable_from))
        return f"These runs cannot tell {listed(list(names), 'from')}"
    best = sorted(found.ranking, key=lambda entry: -entry.probability)[:2]
    if len(best) == 2:
        count = joint_count(found)
        return f"These runs cannot tell {explanation(best[0], count)} from {explanation(best[1], count)}"
    return "Another explanation fits these runs as well"
