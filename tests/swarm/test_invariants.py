"""The table of invariants."""

from pathlib import Path

from achse.swarm.invariants import INVARIANTS, invariant_rows
from achse.swarm.motion.checks import CHECKS, NAMES

ROOT = Path(__file__).parents[2]


def test_names_are_there_once_and_each_has_its_watch() -> None:
    names = [row.name for row in INVARIANTS]
    assert len(set(names)) == len(names)
    for row in INVARIANTS:
        assert row.statement.endswith(".")
        assert row.source
        if row.where:
            source = ROOT / "src" / "achse" / "swarm" / f"{row.where}.py"
            assert f'"{row.name}"' in source.read_text(encoding="utf-8")
    assert tuple(row.name for row in INVARIANTS if not row.where) == NAMES
    assert len(CHECKS) == len(NAMES)


def test_table_of_the_docs_is_that_of_the_code() -> None:
    page = (ROOT / "docs" / "explanation" / "swarm.md").read_text(encoding="utf-8")
    assert "\n".join(invariant_rows()) in page
