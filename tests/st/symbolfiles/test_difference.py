# ruff: noqa: N815 -- IEC names carry their prefix
"""Differences between symbol files, one line each."""

from typing import Any

from achse.iec import DINT, INT, LREAL, IecType, Struct, Variable, iec_type, var
from achse.st.symbolfiles import FileVariable, SymbolFile, differences


def _file(
    *variables: tuple[str, IecType[Any], str], types: tuple[IecType[Any], ...] = ()
) -> SymbolFile:
    items = [FileVariable(name, Variable(type, name=name, at=at)) for name, type, at in variables]
    return SymbolFile("P", items, types)


class Old(Struct, name="ST_P"):
    fX = var(LREAL)


class New(Struct, name="ST_P"):
    fX = var(LREAL)
    nId = var(INT)


def test_equal_files_do_not_differ() -> None:
    file = _file(("GVL.a", INT, "%MW0"), types=(iec_type(Old),))
    assert differences(file, file) == []


def test_what_came_went_and_changed() -> None:
    old = _file(("GVL.a", INT, "%MW0"), ("GVL.b", INT, "%MW2"), types=(iec_type(Old),))
    new = _file(("gvl.A", DINT, "%MW0"), ("GVL.c", INT, "%MW2"), types=(iec_type(New),))
    assert [str(change) for change in differences(old, new)] == [
        "~ type ST_P: STRUCT (8 bytes); fX : LREAL @0"
        " -> STRUCT (16 bytes); fX : LREAL @0; nId : INT @8",
        "~ variable gvl.A: INT AT %MW0 -> DINT AT %MW0",
        "- variable GVL.b: INT AT %MW2",
        "+ variable GVL.c: INT AT %MW2",
    ]


def test_places_can_be_left_out() -> None:
    old, new = _file(("GVL.a", INT, "%MW0")), _file(("GVL.a", INT, "%MW8"))
    assert len(differences(old, new)) == 1
    assert differences(old, new, places=False) == []
