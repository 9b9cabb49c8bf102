"""How sure an answer is, in one word, and why."""

from __future__ import annotations

from collections.abc import Sequence

from snakebot.diagnosis.result import BudgetEntry, Cause, Diagnosis, RankingEntry
from snakebot.diagnosis.show.named import effect_title, explanation, joint_count, runs_in_words
from snakebot.diagnosis.sizes import HALF, LIKELY, NEXT_TO_NOTHING, SURE
from snakebot.in_words import listed


def credible(found: Diagnosis) -> Sequence[Cause]:
    """The causes without those of next to no probability, or that carry next to nothing of the gap, which only help the
    others to fit; all, if none is left.
    """
    told = [
        cause
        for place, cause in enumerate(found.causes)
        if cause.probability > NEXT_TO_NOTHING and _carries(found.budget, place)
    ]
    return told or found.causes


def _carries(budget: Sequence[BudgetEntry], place: int) -> bool:
    """Whether a cause carries more than next to nothing of a gap, or most of a joint's; so too where none is shared
    out.
    """
    shares = [entry for entry in budget if entry.cause == place]
    return not shares or any(
        entry.share > NEXT_TO_NOTHING or max((part or 0.0 for part in entry.by_joint), default=0.0) > HALF
        for entry in shares
    )


def least_probability(found: Diagnosis) -> float:
    """Of the causes that are told."""
    return min((cause.probability for cause in credible(found)), default=0.0)


def tied(found: Diagnosis) -> bool:
    """Whether another explanation is as good, or more than half as likely: a cause's probability is then that of a
    group, not of the one named.
    """
    if any(cause.indistinguishable_from or cause.evidence.get("rivals", 0) > 0 for cause in credible(found)):
        return True
    best = _two_best(found)
    return len(best) == 2 and best[1].probability > HALF * best[0].probability


def _two_best(found: Diagnosis) -> list[RankingEntry]:
    """The two likeliest explanations, of those that say the same the likeliest."""
    ordered = sorted(found.ranking, key=lambda entry: -entry.probability)
    same = [entry for entry in ordered if not _says_else(found, entry)]
    return [entry for entry in ordered if entry not in same[1:]][:2]


def _says_else(found: Diagnosis, entry: RankingEntry) -> bool:
    """Whether an explanation is another one than the credible causes, alone or with something beside them."""
    causes = credible(found)
    names = {cause.effect for cause in causes}
    same_joints = {joint for cause in causes for joint in cause.joints} == set(entry.joints)
    return not names <= set(entry.effects) or (names == set(entry.effects) and not same_joints)


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
    """The best of the other explanations that clearly lose somewhere; none where that is not known."""
    others = (entry for entry in found.ranking if entry.effects and _says_else(found, entry))
    return next((entry for entry in others if entry.worse_in), None)


def tie_sentence(found: Diagnosis) -> str:
    """Which explanations tie."""
    named = next((cause for cause in credible(found) if cause.indistinguishable_from), None)
    if named is not None:
        names = dict.fromkeys(effect_title(n) for n in (named.effect, *named.indistinguishable_from))
        return f"These runs cannot tell {listed(list(names), 'from')}"
    best = _two_best(found)
    if len(best) == 2:
        count = joint_count(found)
        return f"These runs cannot tell {explanation(best[0], count)} from {explanation(best[1], count)}"
    return "Another explanation fits these runs as well"
