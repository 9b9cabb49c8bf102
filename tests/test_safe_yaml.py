"""What is wrong with a text that is no YAML is told in one line, with the line of the file where it stands."""

from __future__ import annotations

import pytest

from snakebot.errors import BadInputError
from snakebot.safe_yaml import load_yaml


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("joints: 5\nlimits: [1,\nname: x\n", "lab.yaml: line 4: not YAML: "),
        ("joints: 5\nname: 'x", "lab.yaml: line 2: not YAML: "),
        ("joints: 5\nname: !!binary x\n", "lab.yaml: line 2: not YAML: "),
        ("joints: 5\nmass: 99999999999999999999\n", "is no int"),
        ("joints: \x01", "lab.yaml: not YAML: "),
        ("joints: 5\njoints: 6\n", "lab.yaml: line 2: joints is given twice, before on line 1"),
    ],
)
def test_says_what_and_on_which_line(text: str, told: str) -> None:
    with pytest.raises(BadInputError) as caught:
        load_yaml(text, "lab.yaml")
    said = str(caught.value)
    assert told in said
    assert "\n" not in said
    assert "unicode string" not in said
