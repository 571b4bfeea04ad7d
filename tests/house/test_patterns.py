"""Regular expressions that every Python we run on matches alike."""

import re
from pathlib import Path

from tests.house.sources import Texts

GROUP_WITHOUT_RETURN = re.compile(r"\(\?>|\)(?:[*+?]|\{[\d,]+\})\+")


def test_no_group_is_possessive(texts: Texts, tracked: list[Path]) -> None:
    """Python 3.11.0 to 3.11.4 miss what follows such a group (gh-106052); single characters are
    fine."""
    groups = [
        f"{path}:{texts[path].count(chr(10), 0, group.start()) + 1}"
        for path in tracked
        if path.suffix == ".py" and path != Path("tests/house/test_patterns.py")
        for group in GROUP_WITHOUT_RETURN.finditer(texts[path])
    ]
    assert groups == []
