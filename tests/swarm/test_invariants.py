"""The table of invariants."""

from pathlib import Path

from achse.swarm.invariants import INVARIANTS, invariant_rows, motion_checks

ROOT = Path(__file__).parents[2]


def test_names_are_there_once_and_each_has_its_watch() -> None:
    names = [row.name for row in INVARIANTS]
    assert len(set(names)) == len(names)
    for row in INVARIANTS:
        assert (row.motion is None) == bool(row.where)
        assert row.statement.endswith(".")
        assert row.source
        if row.where:
            source = ROOT / "src" / "achse" / "swarm" / f"{row.where}.py"
            assert f'"{row.name}"' in source.read_text(encoding="utf-8")
    assert [name for name, _ in motion_checks()] == [row.name for row in INVARIANTS if row.motion]


def test_table_of_the_docs_is_that_of_the_code() -> None:
    page = (ROOT / "docs" / "explanation" / "swarm.md").read_text(encoding="utf-8")
    assert "\n".join(invariant_rows()) in page
