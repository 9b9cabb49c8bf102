"""``diagnose``: from a session to a verdict, room by room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import perf_counter

from threadpoolctl import threadpool_limits

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.evidence.sanity import check_data, check_session
from snakebot.diagnosis.evidence.slow_logs import slow_warning, with_ticks
from snakebot.diagnosis.evidence.ticks import is_slow
from snakebot.diagnosis.evidence.turns import run_on
from snakebot.diagnosis.fit.trial import against_nominal
from snakebot.diagnosis.options import Options, ProgressCallback
from snakebot.diagnosis.proposal.experiment import Proposal, propose
from snakebot.diagnosis.proposal.motions import known_motions
from snakebot.diagnosis.result import Diagnosis
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.random_loss import with_random_loss
from snakebot.diagnosis.search.search import search
from snakebot.diagnosis.show.answer import with_words
from snakebot.diagnosis.verdict import run_by_run, stretches
from snakebot.diagnosis.verdict.at_end import at_end
from snakebot.diagnosis.verdict.bend import bent
from snakebot.diagnosis.verdict.closure import doubt_about_floor
from snakebot.diagnosis.verdict.conclude import conclude
from snakebot.diagnosis.verdict.decision import judge
from snakebot.diagnosis.verdict.left_out import told_of_left_out
from snakebot.effects.registry import find_effect
from snakebot.errors import BadInputError
from snakebot.runlog import Session


def _quiet(text: str, share: float) -> None:
    """No progress is shown."""


def diagnose(
    session: Session,
    *,
    exclude: Sequence[str] = (),
    absent: Sequence[str] = (),
    only: Sequence[str] = (),
    known: Mapping[str, float] | None = None,
    seed: int = 0,
    quick: bool = False,
    progress: ProgressCallback = _quiet,
) -> Diagnosis:
    """Find out where robot and simulation part, which effect causes it, and how far the gap shrinks with it.

    The same session and seed give the same answer.

    Args:
        session: runs of one robot with the nominal robot description.
        exclude, absent, only, known, seed, quick: see ``Options``.
        progress: called with what is being done and the share that is done.

    Raises:
        BadInputError: the session cannot be diagnosed, an option names no effect or parameter, or the file of the
            motions is not sound.
    """
    options = Options(tuple(exclude), tuple(absent), tuple(only), dict(known or {}), seed, quick)
    options.check()
    # Fits run side by side already (``fit.parallel``). The products in them are thin, p x N by N x p: further threads
    # of the linear algebra wait for each other on the same cores, which took twice the processor time.
    with threadpool_limits(limits=1, user_api="blas"):
        return _diagnosed(session, options, progress)


def _diagnosed(session: Session, options: Options, progress: ProgressCallback) -> Diagnosis:
    """The answer to a session."""
    clock = _Clock()
    if not options.quick:
        known_motions()  # a fault in their file is told now, not after the search
    progress("reading the session", 0.0)
    evidence, warnings = _evidence(session)
    clock.lap("prepare")

    library = usable_effects(
        evidence.data,
        over_ground=evidence.ground is not None,
        known=options.known,
        only=options.only,
        exclude=options.exclude,
        absent=options.absent,
    )
    nominal, evidence = against_nominal(evidence)
    found = search(
        evidence,
        library,
        nominal,
        quick=options.quick,
        progress=lambda text, share: progress(text, 0.05 + 0.7 * share),
    )
    found = with_random_loss(evidence, library, found, quick=options.quick)
    evidence = found.evidence
    clock.lap("search")

    progress("what is left over", 0.78)
    judgement = judge(evidence, found, options)
    conclusion = conclude(evidence, found, judgement, library.unnamed, options, progress)
    warnings += judgement.warnings
    named = dict.fromkeys(term.effect for term in judgement.best.hypothesis.terms)
    lacking = [find_effect(name).lacks(evidence.data.robot) for name in named]
    warnings += [text for text in dict.fromkeys(lacking) if text is not None]
    doubts = (
        *map(at_end, conclusion.causes),
        bent(conclusion.causes),
        doubt_about_floor(conclusion.closure.joint_angle),
    )
    warnings += [text for text in doubts if text is not None]
    if conclusion.where.values is not None:
        warnings.append(run_by_run.in_words(conclusion.where.values, evidence.data.joints))
    warnings += stretches.in_words(conclusion.where.times, evidence.data.joints)
    warnings += told_of_left_out(named, conclusion.causes, evidence.usual, library.unnamed, options)

    proposal = Proposal(None, None)
    if not options.quick and conclusion.open_rivals:
        progress("the next experiment", 0.94)
        proposal = propose(evidence, conclusion.open_rivals, conclusion.chosen_probability)
    if proposal.channel is not None:
        warnings.append(proposal.channel)
    if not evidence.floor.known:
        what = "no repeat tells the noise" if evidence.floor.warnings else "no run is repeated"
        warnings.append(f"{what}: the noise floor is that of the encoders alone; repeat one motion")
    clock.lap("conclude")
    progress("done", 1.0)
    return with_words(conclusion.diagnosis(proposal.experiment, warnings, clock.laps_s))


class _Clock:
    """Seconds that each part took, and all together."""

    def __init__(self) -> None:
        self._started = self._mark = perf_counter()
        self.laps_s: dict[str, float] = {}

    def lap(self, name: str) -> None:
        now = perf_counter()
        self.laps_s |= {name: now - self._mark, "total": now - self._started}
        self._mark = now


def _evidence(session: Session) -> tuple[Evidence, list[str]]:
    """The evidence of a session, with warnings about it.

    Raises:
        BadInputError: there is nothing to compare.
    """
    warnings = [*session.warnings, *check_session(session)]
    session, turned = run_on(session)
    warnings += turned
    data = prepare(session)
    warnings += check_data(data)
    evidence = gather(data)
    if not evidence.scoring.decides[evidence.scoring.of_angles].any():
        which = "run that may be fitted" if any(run.hold_out for run in data.runs) else "run"
        raise BadInputError(f"no sample of any {which} has both a command and a reading: nothing to compare")
    guessed = with_ticks(evidence)
    if guessed is not None:
        evidence = gather(guessed)
    if any(is_slow(run) for run in evidence.data.runs):
        warnings.append(slow_warning(evidence.data, guessed is not None))
    return evidence, [*warnings, *evidence.floor.warnings]
