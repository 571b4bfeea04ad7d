"""Symbols by patterns."""

import pytest

from achse.cli.plc.selection import selected
from achse.iec.symbols import SymbolEntry

ENTRIES = [
    SymbolEntry(name, type, 0x4040, 0, 2, 2)
    for name, type in [
        ("MAIN.nCount", "INT"),
        ("MAIN.aPoints", "ARRAY [0..1] OF INT"),
        ("GVL.nCount", "INT"),
    ]
]


@pytest.mark.parametrize(
    ("pattern", "type_pattern", "names"),
    [
        ("*", "*", ["MAIN.nCount", "MAIN.aPoints", "GVL.nCount"]),
        ("main", "*", ["MAIN.nCount", "MAIN.aPoints"]),
        ("*.ncount", "*", ["MAIN.nCount", "GVL.nCount"]),
        ("*", "array [0..1] of *", ["MAIN.aPoints"]),
        ("MAIN.aPoints", "*", ["MAIN.aPoints"]),
        ("M[A]IN.*", "*", []),
    ],
)
def test_names_and_types_are_selected_without_case(
    pattern: str, type_pattern: str, names: list[str]
) -> None:
    assert [entry.name for entry in selected(ENTRIES, pattern, type_pattern)] == names
