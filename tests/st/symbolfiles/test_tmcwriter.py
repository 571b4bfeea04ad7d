# ruff: noqa: N801, N802, N815 -- IEC names carry their prefix
"""What is written as .tmc reads back as the same types, variables and initial values."""

from datetime import timedelta

from achse.iec import (
    ARRAY,
    BIT,
    BOOL,
    INT,
    LREAL,
    STRING,
    TIME,
    UINT,
    WSTRING,
    AliasType,
    Enumeration,
    FunctionBlock,
    Struct,
    SubrangeType,
    Union,
    Variable,
    iec_type,
    method,
    pointer_to,
    reference_to,
    var,
    var_input,
)
from achse.iec.datatypes import encode_types
from achse.iec.describe import describe_type, types_within
from achse.st.symbolfiles import FileTask, FileVariable, SymbolFile, read_tmc, write_tmc


class E_Mode(Enumeration, base=UINT, comment=" how"):
    OFF = 0
    ON = 7


class U_Raw(Union):
    nWord = var(UINT)
    aBytes = var(ARRAY(SubrangeType(INT, 0, 9), (0, 0)))


class ST_Inner(Struct, pack=1, attributes={"pack_mode": "1"}):
    bFlag = var(BIT)
    bOther = var(BIT)
    sText = var(STRING(5, "utf-8"), "ä$'")
    wsText = var(WSTRING(4), 'a"ß')
    eMode = var(E_Mode, E_Mode.ON)


class FB_Base(FunctionBlock):
    fSpeed = var_input(LREAL, 2.5, comment=" mm/s & <more>")

    @method(BOOL, fTo=LREAL)
    def Start(self, to: float) -> bool:
        return True


class FB_Axis(FB_Base, comment="moves"):
    aInner = var(ARRAY(ST_Inner, (1, 2), (-1, 0)))
    pBack = var(pointer_to(ARRAY(INT, (0, 3))))
    rName = var(reference_to(STRING(80)))
    tWait = var(TIME, timedelta(milliseconds=1500), persistent=True)
    uRaw = var(U_Raw)

    @method(outputs={"stOut": ST_Inner}, aIn=ARRAY(INT, (0, 2)))
    def Inspect(self, values: list[int]) -> object:
        return {}


def _file() -> SymbolFile:
    axis = iec_type(FB_Axis)
    named = AliasType("Lib.Sub.T_Limited", SubrangeType(INT, -5, 5, name="T_Range"))
    return SymbolFile(
        "Plant <1>",
        [
            FileVariable("MAIN.fb", Variable(axis, name="MAIN.fb", at="%MB16"), 1),
            FileVariable(
                "GVL.aNames",
                Variable(
                    ARRAY(STRING(10), (0, 2)),
                    ["", "x$y", "z"],
                    name="GVL.aNames",
                    at="%QB4",
                    attributes={"unit": 'a"b'},
                ),
                is_global=True,
            ),
            FileVariable("MAIN.bBit", Variable(BOOL, True, name="MAIN.bBit", at="%IX2.5")),
            FileVariable("MAIN.nSmall", Variable(named, 3, name="MAIN.nSmall", at="%MW2")),
        ],
        tasks=[FileTask("A", 1_000_000, 3), FileTask("B")],
        port=852,
    )


def test_types_read_back_with_the_same_table_entries() -> None:
    written = _file()
    read = read_tmc(write_tmc(written), "again.tmc")

    def table(file: SymbolFile) -> bytes:
        types = types_within([item.declared.type for item in file.variables])
        return encode_types([describe_type(type) for type in types])

    assert table(read) == table(SymbolFile("", written.variables))


def test_variables_places_tasks_and_values_read_back() -> None:
    written = _file()
    read = read_tmc(write_tmc(written), "again.tmc")

    def facts(file: SymbolFile) -> set[object]:
        return {
            (
                item.name,
                item.declared.type.name,
                str(item.declared.address).replace("B", "").replace("W", ""),
                item.declared.initial_bytes(),
                tuple(item.declared.attributes.items()),
                item.task,
                item.is_global,
            )
            for item in file.variables
        }

    assert facts(read) == facts(written)
    assert (read.name, read.port, list(read.tasks)) == ("Plant <1>", 852, list(written.tasks))


def test_equal_files_are_equal_bytes() -> None:
    assert write_tmc(_file()) == write_tmc(_file())
    once = write_tmc(read_tmc(write_tmc(_file()), "again.tmc"))
    assert write_tmc(read_tmc(once, "again.tmc")) == once


def test_the_real_thing_survives(tmc: bytes) -> None:
    first = read_tmc(tmc, "plant.tmc")
    second = read_tmc(write_tmc(first), "again.tmc")
    assert {v.name: v.declared.initial_bytes() for v in second.variables} == {
        v.name: v.declared.initial_bytes() for v in first.variables
    }
