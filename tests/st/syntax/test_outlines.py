"""Outlines of units: of each kind, and of the libraries."""

from typing import Any

import pytest

from achse.st.declared.standard import library_files
from achse.st.syntax.outlines import UnitOutline, outline_of
from achse.st.syntax.parser import parse


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("VAR_GLOBAL a, B : INT; c : BOOL; END_VAR", ("L", "GlobalList", 0, ("a", "b", "c"))),
        ("VAR_GLOBAL a : INT; A : INT; END_VAR", ("L", "GlobalList", 0, ("a",))),
        ("TYPE E : (On, Off := 5); END_TYPE", ("E", "TypeDeclaration", 0, (), (), ("on", "off"))),
        ("TYPE S : STRUCT n : INT; END_STRUCT END_TYPE", ("S", "TypeDeclaration", 0)),
        ("FUNCTION F : INT END_FUNCTION", ("F", "Function", 0)),
        ("FUNCTION_BLOCK B END_FUNCTION_BLOCK", ("B", "FunctionBlock", 0)),
        (
            "FUNCTION_BLOCK INTERNAL B END_FUNCTION_BLOCK",
            ("B", "FunctionBlock", 0, (), (), (), True),
        ),
        ("PROGRAM P END_PROGRAM", ("P", "Program", 0)),
        ("INTERFACE I END_INTERFACE", ("I", "Interface", 0)),
        ("NAMESPACE N END_NAMESPACE", ("N", "Namespace", 0)),
    ],
)
def test_an_outline_has_name_kind_and_the_names_that_need_no_unit_in_front(
    text: str, expected: tuple[Any, ...]
) -> None:
    (unit,) = parse(text, name="L").check().units
    outline = outline_of(unit)
    assert outline.at == unit.at
    assert outline._replace(at=0) == UnitOutline(*expected)


@pytest.mark.parametrize("kind", ["VAR_GLOBAL a : INT; END_VAR", "TYPE E : (On, Off); END_TYPE"])
def test_names_of_qualified_only_units_need_the_unit_in_front(kind: str) -> None:
    (unit,) = parse("{attribute 'Qualified_Only'}\n" + kind).check().units
    assert not any(outline_of(unit)[3:])


def test_outlines_of_the_libraries_are_those_of_their_units() -> None:
    for file in library_files():
        kinds = [(item.name, item.kind, item.at) for item in file.outlines]
        are_internal = [outline_of(unit).is_internal for unit in file.parsed.units]
        assert [item.is_internal for item in file.outlines] == are_internal
        assert kinds == [(unit.name, type(unit).__name__, unit.at) for unit in file.parsed.units]
        assert [list(map(list, item[3:6])) for item in file.outlines] == [
            list(map(list, outline_of(unit)[3:6])) for unit in file.parsed.units
        ]
