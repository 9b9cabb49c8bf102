"""The picture of a diagnosis shows the rooms that there are, in the order of the data."""

from __future__ import annotations

import re
from pathlib import Path

import snakebot.diagnosis


def test_the_picture_of_a_diagnosis_shows_its_rooms_in_order(root: Path) -> None:
    drawn = re.findall(
        r"<text [^>]*>([a-z]+)</text>", (root / "docs/diagnosis.svg").read_text(encoding="utf-8")
    )
    folder = Path(snakebot.diagnosis.__file__).parent
    rooms = {path.parent.name for path in folder.glob("*/__init__.py")}
    assert snakebot.diagnosis.__doc__ is not None
    (chain,) = re.findall(r"Session -> (.*)", snakebot.diagnosis.__doc__)
    assert [word for word in drawn if word in rooms] == [
        word for word in chain.split(" -> ") if word in rooms
    ]
    assert rooms <= set(drawn)


def test_every_picture_of_the_pages_names_its_command(root: Path) -> None:
    makers = ("make_pictures.py", "picture_of_page.py")
    told = "".join((root / "tools" / name).read_text(encoding="utf-8") for name in makers)
    for page in [root / "README.md", *(root / "docs").glob("*.md")]:
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
            assert f"docs/{Path(picture).name}" in told, f"{page.name}: {picture}"
