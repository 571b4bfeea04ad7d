"""What strangers met with: each clause names a test that is there."""

import ast
import csv
from functools import cache
from pathlib import Path

CLAUSES = Path("tests/data/strangers.tsv")
SECTIONS = {"1", "2", "3", "4"}
"""The wire, sources as the vendor's compiler takes them, the first ten minutes, speed."""


@cache
def _tests_in(path: Path) -> frozenset[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    return frozenset(node.name for node in tree.body if isinstance(node, functions))


def _rows(root: Path) -> list[dict[str, str]]:
    with (root / CLAUSES).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def test_each_clause_is_there_once_and_says_what_it_is(root: Path) -> None:
    rows = _rows(root)
    keys = [row["clause"] for row in rows]
    assert len(set(keys)) == len(keys)
    assert {key.partition(".")[0] for key in keys} == SECTIONS
    assert all(row["text"] and row["test"].count("::") == 1 for row in rows)


def test_each_clause_is_shown_by_a_test_that_is_there(root: Path) -> None:
    for row in _rows(root):
        file, _, test = row["test"].partition("::")
        assert test.startswith("test_"), row["clause"]
        assert test in _tests_in(root / file), row["clause"]
