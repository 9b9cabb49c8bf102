"""From answers and labels to figures, each with its 95 % interval."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from blind.cases import SEVERAL
from blind.worn_kinds import kind_of
from blind.worn_scores import LEAST, dominant_named, share_errors

PLAIN = 2.7  # reached size from which an effect counts as "at 3 floors or more"
LOW_PROBABILITY = 0.5
CHANCE_DRAWS = 200
Answer = dict[str, Any]
Label = dict[str, Any]
Pair = tuple[Label, Answer | None]  # None: no answer came, which counts as wrong


@dataclass(frozen=True)
class Figure:
    """A line of the table. ``value`` is None where no case bears on it."""

    key: str
    text: str
    aim: str
    value: float | None
    low: float | None
    high: float | None
    cases: int
    met: bool | None

    def mapping(self) -> dict[str, Any]:
        return asdict(self)

    def __str__(self) -> str:
        """The line: what, aim, value, interval, cases, whether it is met."""
        head = f"{self.text:<46} {self.aim:>8}"
        if self.value is None:
            return f"{head}   " + (
                f"none of {self.cases}  MISSED" if self.met is False else "no case bears on it"
            )
        verdict = "" if self.met is None else "met" if self.met else "MISSED"
        interval = "" if self.low is None else f"[{self.low:.3f}, {self.high:.3f}]"
        return f"{head} {self.value:7.3f} {interval:>16} {self.cases:5d}  {verdict}".rstrip()


def wilson(hits: int, cases: int) -> tuple[float, float]:
    """Interval of a proportion that holds for few cases, too (Wilson 1927)."""
    z, n = 1.959964, max(cases, 1)
    p = hits / n
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * (p * (1 - p) / n + z * z / (4 * n * n)) ** 0.5
    return max(0.0, centre - half), min(1.0, centre + half)


def group(cause: dict[str, Any]) -> set[str]:
    return {cause["effect"], *cause["indistinguishable_from"]}


def first_cause(answer: Answer | None) -> dict[str, Any] | None:
    return answer["causes"][0] if answer and answer["causes"] else None


def names_it(label: Label, answer: Answer | None) -> bool:
    cause = first_cause(answer)
    return cause is not None and label["effects"][0]["name"] in group(cause)


def stage_right(label: Label, answer: Answer | None) -> bool:
    return answer is not None and answer["where"]["stage"] == label["effects"][0]["stage"]


def joints_right(label: Label, answer: Answer | None) -> bool:
    should = label["effects"][0]["joints"] or list(range(1, label.get("joints", 5) + 1))
    return answer is not None and sorted(answer["where"]["joints"]) == sorted(should)


def unexplained(answer: Answer | None) -> bool:
    return answer is not None and answer["verdict"] in ("partly", "unexplained")


def has_cause_or_gap(answer: Answer | None) -> bool:
    return answer is None or bool(answer["causes"]) or answer["verdict"] != "no_gap"


def caught_left_out(answer: Answer | None) -> bool:
    cause = first_cause(answer)
    return unexplained(answer) or (cause is not None and cause["probability"] < LOW_PROBABILITY)


def caught_undoubted(answer: Answer | None) -> bool:
    """The same, without the part of the probability that goes to look-alikes because they may not be named."""
    cause = first_cause(answer)
    if unexplained(answer) or cause is None:
        return unexplained(answer)
    return bool(cause["probability"] / cause.get("evidence", {}).get("share_of_named", 1.0) < LOW_PROBABILITY)


def names_its_kind(label: Label, answer: Answer | None) -> bool:
    """The true effect was left out, which was not caught: another of its kind is named, but for those of the body."""
    if answer is None or label["stratum"] != "left_out" or caught_left_out(answer):
        return False
    cause, true = first_cause(answer), label["effects"][0]
    return cause is not None and true["stage"] != "body" and kind_of(cause["effect"]) == kind_of(true["name"])


def claims_another(answer: Answer | None, true: Set[str]) -> bool:
    """Whether the first cause is said with a half or more and, with its group, is none of the ``true`` names."""
    cause = first_cause(answer)
    return cause is not None and cause["probability"] >= LOW_PROBABILITY and not true & group(cause)


def accused(label: Label, answer: Answer | None) -> bool:
    """A cause is claimed in a robot that has another fault, or none."""
    left_out = label["stratum"] == "left_out"
    return claims_another(answer, set() if left_out else {e["name"] for e in label["effects"]})


def size(label: Label) -> float:
    return min((e["size"] for e in label["effects"]), default=0.0)


def all_named(label: Label, answer: Answer | None) -> bool:
    """Whether the first causes, as many as there are effects, are the effects, in any order."""
    if answer is None:
        return False
    count = len(label["effects"])
    named: set[str] = set().union(*(group(c) for c in answer["causes"][:count]))
    return len(answer["causes"]) >= count and all(e["name"] in named for e in label["effects"])


def plain_several(label: Label) -> bool:
    """Several effects, each large enough to count."""
    return label["stratum"] in SEVERAL and size(label) >= PLAIN


def all_named_where_detectable(pairs: Sequence[Pair], told: dict[int, Answer], stratum: str) -> list[bool]:
    """Of robots of a stratum with several effects, each of them detectable: all are named, or they are by one who was
    told them (answers by index in ``pairs``).
    """
    found = []
    for i, (label, answer) in enumerate(pairs):
        if label["stratum"] != stratum or size(label) < PLAIN:
            continue
        named = all_named(label, answer)
        if named or all_named(label, told.get(i)):
            found.append(named)
    return found


def parameter_errors(pairs: Sequence[Pair]) -> tuple[list[float], list[bool]]:
    """Relative error and whether the interval holds the truth, of every fitted parameter of effects named exactly."""
    errors, covered = [], []
    for label, answer in pairs:
        true = {e["name"]: e["values"] for e in label["effects"]}
        for cause in answer["causes"] if answer else ():
            for name, value in true.get(cause["effect"], {}).items():
                found = cause["parameters"].get(name)
                if (
                    found is None
                    or name in ("link", "angle_deg")
                    or found.get("fixed")
                    or not found.get("ci95")
                ):
                    continue
                unit = 1.0 if name == "gain" or name.endswith("_scale") else 0.0
                errors.append(abs(found["estimate"] - value) / max(abs(value - unit), 1e-12))
                covered.append(found["ci95"][0] <= value <= found["ci95"][1])
    return errors, covered


def probabilities(pairs: Sequence[Pair]) -> tuple[np.ndarray, np.ndarray]:
    """Probability and truth of every cause in every answer; of an unanswered case there is none."""
    p, right = [], []
    for label, answer in pairs:
        true = {e["name"] for e in label["effects"] if e.get("share") is None or e["share"] >= LEAST}
        if label["stratum"] == "left_out":
            true = set()
        for cause in answer["causes"] if answer else ():
            p.append(float(cause["probability"]))
            right.append(bool(true & group(cause)))
    return np.array(p), np.array(right, dtype=float)


def calibration_error(p: np.ndarray, right: np.ndarray, bins: int = 10) -> float:
    """Expected calibration error over bins of equal width."""
    return float(_calibration_errors(p, right[None], bins)[0])


def calibration_error_beyond_chance(p: np.ndarray, right: np.ndarray) -> float:
    """The same less what an answerer comes to in the mean who is right exactly as often as he says, on as many causes:
    few in a bin are off by chance.
    """
    by_chance = np.random.default_rng(0).random((CHANCE_DRAWS, p.size)) < p
    return calibration_error(p, right) - float(_calibration_errors(p, by_chance).mean())


def _calibration_errors(p: np.ndarray, right: np.ndarray, bins: int = 10) -> np.ndarray:
    """(D,) errors of D outcomes (D, n) of the same n causes."""
    index = np.minimum((p * bins).astype(int), bins - 1)
    in_bin = (index[:, None] == np.arange(bins)).astype(float)
    return np.asarray(np.abs((right - p) @ in_bin).sum(axis=1) / p.size)


def share(
    key: str, text: str, aim: str, least: float | None, most: float | None, hits: Sequence[bool]
) -> Figure:
    """A proportion with its Wilson interval; no case, no value."""
    if not hits:
        return Figure(key, text, aim, None, None, None, 0, None)
    value = sum(hits) / len(hits)
    low, high = wilson(sum(hits), len(hits))
    met = (
        None
        if least is most is None
        else (least is None or value >= least) and (most is None or value <= most)
    )
    return Figure(key, text, aim, value, low, high, len(hits), met)


def _statistic(
    key: str,
    text: str,
    aim: str,
    most: float,
    data: Sequence[np.ndarray],
    of: Callable[..., float],
    least: bool = False,
) -> Figure:
    """A statistic of paired samples with a bootstrap interval; ``most`` is the least where ``least``."""
    n = len(data[0])
    if n == 0:
        return Figure(key, text, aim, None, None, None, 0, None)
    value, rng = of(*data), np.random.default_rng(0)
    draws = [of(*(d[i] for d in data)) for i in (rng.integers(n, size=n) for _ in range(500))]
    low, high = np.quantile(draws, [0.025, 0.975])
    return Figure(
        key, text, aim, value, float(low), float(high), n, value >= most if least else value <= most
    )


def figures(
    pairs: Sequence[Pair],
    oracle: dict[int, float] | None = None,
    told: dict[int, Answer] | None = None,
    alike: Set[int] = frozenset(),
) -> list[Figure]:
    """All lines of the table. By index in ``pairs``: ``oracle``: closure reached by the one who knows the effect;
    ``told``: what he says who is told the effects of a case of several that was missed; ``alike``: of those where
    another of the kind of an effect that was left out is named, those in which it foretells the same.
    """

    def of(stratum: str, least: float = 0.0) -> list[Pair]:
        return [(lab, a) for lab, a in pairs if lab["stratum"] == stratum and size(lab) >= least]

    plain, quiet = of("single", PLAIN), of("no_gap")
    unknown, left_out = of("unknown", PLAIN), of("left_out", PLAIN)
    two, three = of("pair", PLAIN), of("triple", PLAIN)
    resolved = [(lab, a) for lab, a in plain if (c := first_cause(a)) and not c["indistinguishable_from"]]
    moving = [(lab, a) for lab, a in plain if lab["effects"][0]["stage"] != "body"]
    grounded = [(lab, a) for lab, a in plain if lab["effects"][0]["stage"] == "body"]
    errors, covered = parameter_errors([*plain, *two, *three])
    e = np.array(errors)
    p, right = probabilities(pairs)
    angles = np.array([v for lab, a in moving if (v := closed(lab, a)) is not None])
    speeds = np.array([v for lab, a in grounded if (v := closed(lab, a)) is not None])
    rows = [
        share("named", "cause named, single >= 3x, gaits alone", ">= 85 %", 0.85, None, [names_it(*x) for x in plain]),
        share(
            "exact", "exact cause where resolved", ">= 90 %", 0.9, None,
            [first_cause(a)["effect"] == lab["effects"][0]["name"] for lab, a in resolved],  # type: ignore[index]
        ),
        share("stage", "stage right, single >= 3x", ">= 98 %", 0.98, None, [stage_right(*x) for x in plain]),
        share("joints", "joints right, single >= 3x", ">= 98 %", 0.98, None, [joints_right(*x) for x in moving]),
        share("pairs", "both causes of a pair >= 3x", ">= 75 %", 0.75, None, [all_named(*x) for x in two]),
        share("pairs_detectable", "the same where both are detectable", ">= 80 %", 0.8, None,
              [] if told is None else all_named_where_detectable(pairs, told, "pair")),
        share("triples", "all causes of a triple >= 3x", ">= 60 %", 0.6, None, [all_named(*x) for x in three]),
        share("triples_detectable", "the same where all are detectable", ">= 60 %", 0.6, None,
              [] if told is None else all_named_where_detectable(pairs, told, "triple")),
        _statistic("error_median", "parameter error, median", "<= 5 %", 0.05, [e], lambda x: float(np.median(x))),
        _statistic(
            "error_p90", "parameter error, 90th percentile", "<= 15 %", 0.15, [e], lambda x: float(np.quantile(x, 0.9))
        ),
        share("coverage", "coverage of 95 % intervals", "90-98 %", 0.9, 0.98, covered),
        share("false_alarms", "false alarms, no gap", "<= 2 %", None, 0.02, [has_cause_or_gap(a) for _, a in quiet]),
        share("unknown", "unknown >= 3x: unexplained", ">= 85 %", 0.85, None, [unexplained(a) for _, a in unknown]),
        share("wrongly", "known >= 3x: unexplained", "<= 5 %", None, 0.05, [unexplained(a) for _, a in plain]),
        share(
            "left_out", "left out >= 3x: unexplained or p < 0.5", ">= 85 %", 0.85, None,
            [caught_left_out(a) for _, a in left_out],
        ),
        share(
            "left_out_alike", "the same, or its kind within a floor", ">= 80 %", 0.80, None,
            [
                caught_left_out(a) or i in alike for i, (lab, a) in enumerate(pairs)
                if lab["stratum"] == "left_out" and size(lab) >= PLAIN
            ],
        ),
        share(
            "left_out_undoubted", "the same, if --exclude itself raised no doubt", "none", None, None,
            [caught_undoubted(a) for _, a in left_out],
        ),
        share(
            "left_out_joints", "left out >= 3x: joints right", ">= 98 %", 0.98, None,
            [joints_right(*x) for x in left_out if x[0]["effects"][0]["stage"] != "body"],
        ),
        _statistic("ece", "calibration error (ECE)", "<= 0.05", 0.05, [p, right], calibration_error),
        _statistic(
            "ece_beyond_chance", "the same less that of chance", "<= 0.03", 0.03, [p, right],
            calibration_error_beyond_chance,
        ),
        _statistic(
            "brier", "Brier score", "<= 0.10", 0.10, [p, right], lambda q, r: float(np.mean((q - r) ** 2))
        ),
        _statistic(
            "closure", "closure of joint angles, single >= 3x, median", ">= 0.95", 0.95, [angles],
            lambda x: float(np.median(x)), least=True,
        ),
        _statistic(
            "closure_speed", "closure of forward speed, body >= 3x, median", ">= 0.95", 0.95, [speeds],
            lambda x: float(np.median(x)), least=True,
        ),
    ]  # fmt: skip
    worn = of("worn")
    rows += [
        share(
            "worn", "dominant fault of a worn robot named", ">= 85 %", 0.85, None,
            [dominant_named(*x) for x in worn],
        ),
        share(
            "worn_shares", "shares of a worn robot's gap within .1", ">= 85 %", 0.85, None,
            [error <= 0.1 for x in worn for error in share_errors(*x)],
        ),
    ]  # fmt: skip
    lost = [w - mine for i, w in (oracle or {}).items() if (mine := closed(*pairs[i])) is not None]
    rows.append(
        _statistic(
            "oracle", "closure lost against the oracle, median", "<= 0.03", 0.03, [np.array(lost, dtype=np.float64)],
            lambda x: float(np.median(x)),
        )
    )  # fmt: skip
    return rows


def closed(label: Label, answer: Answer | None) -> float | None:
    """Closure of what the first effect moves: joint angles, or for the body the forward speed."""
    if answer is None or label["effects"][0]["name"] == "encoder_noise":
        return None
    side = "forward_speed" if label["effects"][0]["stage"] == "body" else "joint_angle"
    found = answer["closure"][side]
    return None if found is None or found["closed"] is None else float(found["closed"])


def power(pairs: Sequence[Pair]) -> dict[str, dict[str, tuple[int, int]]]:
    """Hits and cases by effect and asked size: how visible an effect must be to be named."""
    table: dict[str, dict[str, tuple[int, int]]] = {}
    for label, answer in pairs:
        if label["stratum"] != "single":
            continue
        row = table.setdefault(label["effects"][0]["name"], {})
        hits, cases = row.get(key := _size_class(label["asked_size"]), (0, 0))
        row[key] = (hits + names_it(label, answer), cases + 1)
    return table


def _size_class(asked: float) -> str:
    return "low" if asked < 2 else "middle" if asked < 5 else "high"


def confusion(pairs: Sequence[Pair]) -> tuple[list[str], list[str], np.ndarray]:
    """Truth (rows) against the first cause (columns); a group that holds the truth counts as the truth."""
    rows: dict[str, dict[str, int]] = {}
    for label, answer in pairs:
        if len(label["effects"]) > 1:
            continue
        true = label["effects"][0]["name"] if label["effects"] else "no gap"
        if label["stratum"] == "left_out":
            true += " (left out)"
        cause = first_cause(answer)
        if answer is None:
            said = "no answer"
        elif cause is None:
            said = answer["verdict"].replace("_", " ")
        else:
            said = true if true in group(cause) else cause["effect"]
        row = rows.setdefault(true, {})
        row[said] = row.get(said, 0) + 1
    truths = sorted(rows)
    said_all = sorted({s for row in rows.values() for s in row})
    return truths, said_all, np.array([[rows[t].get(s, 0) for s in said_all] for t in truths])
