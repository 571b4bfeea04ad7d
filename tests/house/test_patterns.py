"""Regular expressions that every Python we run on matches alike."""

import re
from pathlib import Path

import pytest

GROUP_WITHOUT_RETURN = re.compile(r"\(\?>|\)(?:[*+?]|\{[\d,]+\})\+")


@pytest.mark.parametrize("folder", ["src", "benchmarks", "tests"])
def test_no_group_is_possessive(folder: str) -> None:
    """Python 3.11.0 to 3.11.4 miss what follows such a group (gh-106052); single characters are
    fine."""
    for path in Path(folder).rglob("*.py"):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = GROUP_WITHOUT_RETURN.search(line)
            assert found is None or path == Path("tests/house/test_patterns.py"), f"{path}:{number}"
