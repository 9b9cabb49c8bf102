"""A drawing of a snake, or of joints on a bench, with some of them marked: SVG, in the colours of the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

WIDTH = 440.0  # of the drawing, in its own units, as are all lengths below
MOST_LABELLED = 16  # joints that all have their number beside them; of more only those that are marked
LINK, RADIUS = 15.0, 12.0  # most width of a link, most radius of a joint
LEAST_SHADE = 0.12  # of a joint that carries nothing but is marked


@dataclass(frozen=True)
class Drawing:
    """``share`` of what is drawn (0 to 1) that each joint carries; ``marked`` joints and links (1-based) have a ring.

    Attributes:
        share: (joints,).
        body: links in a row, joined; else separate servos on a bench.
        label: for those who do not see it.
    """

    share: Sequence[float]
    marked: Sequence[int] = ()
    links: Sequence[int] = ()
    body: bool = True
    label: str = ""
    kind: str = field(default="drawing", init=False)

    def svg(self) -> str:
        """The drawing; it holds numbers and fixed words only, so that nothing in it needs quoting but the label."""
        return _snake(self) if self.body else _bench(self)


def _snake(drawing: Drawing) -> str:
    joints = len(drawing.share)
    count = joints + 1
    step = (WIDTH - 40) / count
    height = 104.0
    swing = min(20.0, step * 0.45)
    points = [
        (20 + i * step, 52 + swing * math.sin(2 * math.pi * i / max(count, 3) * 1.5))
        for i in range(count + 1)
    ]
    thick = min(LINK, step * 0.5)
    parts = []
    for number, (a, b) in enumerate(pairwise(points), start=1):
        kind = "link marked" if number in drawing.links else "link"
        parts.append(
            _tag(
                "line", {"class": kind, "x1": a[0], "y1": a[1], "x2": b[0], "y2": b[1], "stroke-width": thick}
            )
        )
        if number in drawing.links and len(drawing.links) < count:
            middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
            parts.append(_text(middle[0], middle[1] + thick + 20, f"link {number}", "strong"))
    for joint, (x, y) in enumerate(points[1:-1], start=1):
        parts += _joint(drawing, joint, x, y, min(RADIUS, step * 0.36))
    return _svg(drawing, height, parts)


def _bench(drawing: Drawing) -> str:
    joints = len(drawing.share)
    step, height = min((WIDTH - 20) / joints, 90.0), 118.0
    first = WIDTH / 2 - step * joints / 2
    box = min(46.0, step * 0.72)
    parts = []
    for joint in range(1, joints + 1):
        x, y = first + (joint - 0.5) * step, 66.0
        parts.append(
            _tag(
                "rect",
                {
                    "class": "servo",
                    "x": x - box / 2,
                    "y": y - box * 0.4,
                    "width": box,
                    "height": box * 0.8,
                    "rx": 4,
                },
            )
        )
        parts.append(
            _tag(
                "line",
                {
                    "class": "link",
                    "x1": x,
                    "y1": y,
                    "x2": x + box * 0.42,
                    "y2": y - box * 0.78,
                    "stroke-width": box * 0.16,
                },
            )
        )
        parts += _joint(drawing, joint, x, y, box * 0.27)
    return _svg(drawing, height, parts)


def _joint(drawing: Drawing, joint: int, x: float, y: float, radius: float) -> list[str]:
    share = min(max(drawing.share[joint - 1], 0.0), 1.0)
    marked = joint in drawing.marked
    shade = max(share, LEAST_SHADE if marked else 0.0)
    parts = [_tag("circle", {"class": "joint", "cx": x, "cy": y, "r": radius})]
    if shade > 0.01:
        parts.append(_tag("circle", {"class": "share", "cx": x, "cy": y, "r": radius, "fill-opacity": shade}))
    if marked:
        parts.append(_tag("circle", {"class": "ring", "cx": x, "cy": y, "r": radius + 4}))
    if marked or len(drawing.share) <= MOST_LABELLED:
        kind = "inside strong" if marked else "inside"
        parts.append(_text(x, y + radius * 0.38, str(joint), kind + (" light" if shade > 0.55 else "")))
    if share >= 0.05 and (marked or len(drawing.share) <= MOST_LABELLED):
        parts.append(
            _text(x, y - radius - 9 if drawing.body else y + radius + 27, f"{100 * share:.0f} %", "strong")
        )
    return parts


def _svg(drawing: Drawing, height: float, parts: Sequence[str]) -> str:
    from html import escape

    box = f'viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(drawing.label, quote=True)}"'
    return f'<svg class="drawing" {box}>{"".join(parts)}</svg>'


def _tag(name: str, attributes: Mapping[str, object]) -> str:
    texts = [
        f'{key}="{value:.2f}"' if isinstance(value, float) else f'{key}="{value}"'
        for key, value in attributes.items()
    ]
    return f"<{name} {' '.join(texts)}/>"


def _text(x: float, y: float, text: str, kind: str, anchor: str = "middle") -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'
