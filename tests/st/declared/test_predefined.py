"""Types that no source declares: which one a name stands for, and what a symbol file adds."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import pytest

from achse.iec import BOOL, DINT, INT, EnumType, IecType
from achse.iec.errors import DeclarationError
from achse.st.declared.predefined import PredefinedTypes
from achse.st.declared.signatures import BlockSignature
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location, SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.values.values import Constant


class Side(IntEnum):
    Left = 11
    Right = 12


SIDE = EnumType(Side, INT, name="E_Side")


class File:
    """A symbol file with one enumeration; it has doubts about `T_Two` and a fault in `T_Bad`."""

    names: Sequence[str] = ("plant.tmc",)

    def type(self, name: str) -> IecType[Any] | None:
        if name == "T_Two":
            raise DeclarationError("T_Two is A.T_Two or B.T_Two")
        if name == "T_Bad":
            raise SourceError(
                [Diagnostic(Location("plant.tmc", 3, 5), "no type", Code.UNKNOWN_TYPE)]
            )
        return SIDE if name == "E_Side" else None

    def enumerations(self, value: str) -> Sequence[EnumType[Any]]:
        return [SIDE] if value == "right" else []

    def constant(self, name: str) -> Constant | None:
        return Constant(6, INT) if name == "list.cmost" else None

    def has_property(self, block: str, name: str) -> bool:
        return (block, name) == ("FB_X", "Rate")

    def signature(self, name: str) -> BlockSignature | None:
        return BlockSignature("FB_Base") if name == "FB_X" else None


GIVEN = PredefinedTypes({"A": DINT, "B": BOOL, "E_Side": INT}, 8)
WITH_FILE = PredefinedTypes({"A": DINT}, 8, File())


def test_dt_is_date_and_time_to_clients() -> None:
    for name in ("DT", "dt", "DATE_AND_TIME"):
        type = PredefinedTypes({}, 8).find(name, 0)
        assert type is not None
        assert type.name == "DATE_AND_TIME"


def test_names_have_no_case_and_a_name_space_may_stand_in_front() -> None:
    assert GIVEN.find("a", 0) is DINT
    assert GIVEN.find("Lib.Sub.b", 0) is BOOL
    assert GIVEN.find("C", 0) is None
    assert "a" in GIVEN
    assert "C" not in GIVEN


def test_elementary_types_are_there_also_by_their_long_names() -> None:
    assert GIVEN.find("dint", 0) is DINT
    long, short = GIVEN.find("LDATE_AND_TIME", 0), GIVEN.find("LDT", 0)
    assert long is short is not None
    assert "DINT" not in GIVEN  # not handed in


@pytest.mark.parametrize("pointer_size", [4, 8])
def test_some_are_as_wide_as_a_pointer(pointer_size: int) -> None:
    type = PredefinedTypes({}, pointer_size).find("PVOID", 0)
    assert type is not None
    assert type.size == pointer_size


def test_a_symbol_file_has_what_is_in_neither() -> None:
    assert WITH_FILE.find("A", 0) is DINT
    assert WITH_FILE.find("E_Side", 0) is SIDE
    assert WITH_FILE.find("E_Other", 0) is None
    assert [(item.value, item.type) for item in WITH_FILE.values("right")] == [(12, SIDE)]
    assert WITH_FILE.values("left") == []
    assert (WITH_FILE.files, GIVEN.files, GIVEN.values("right")) == (("plant.tmc",), (), [])


def test_doubts_are_reported_where_the_name_stands_and_faults_where_they_are() -> None:
    with pytest.raises(Unexpected) as doubt:
        WITH_FILE.find("T_Two", 7)
    assert (doubt.value.at, doubt.value.message) == (7, "T_Two is A.T_Two or B.T_Two")
    with pytest.raises(SourceError):
        WITH_FILE.find("T_Bad", 7)


def test_values_of_lists_and_properties_come_from_files() -> None:
    assert WITH_FILE.constant(["lib", "list", "cmost"]) == Constant(6, INT)
    assert WITH_FILE.constant(["list", "other"]) is None
    assert GIVEN.constant(["list", "cmost"]) is None
    assert WITH_FILE.has_property("FB_X", "Rate")
    assert not WITH_FILE.has_property("FB_X", "Speed")
    assert WITH_FILE.signature("FB_X") == BlockSignature("FB_Base")
    assert GIVEN.signature("FB_X") is None
    assert not GIVEN.has_property("FB_X", "Rate")
