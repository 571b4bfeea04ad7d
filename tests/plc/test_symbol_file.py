"""A running PLC as a symbol file."""
# ruff: noqa: N801, N815 (IEC names)

from achse.iec import ARRAY, BOOL, INT, Address, GlobalVariables, Program, Struct, var
from achse.iec.variables import Section, Variable
from achse.plc import PlcRuntime, Task
from achse.plc.symbol_file import symbol_file


class ST_Part(Struct):
    nId = var(INT, 3)


class GVL(GlobalVariables):
    aParts = var(ARRAY(ST_Part, (1, 2)), [{"nId": 4}, {}], comment="all")
    bOut = var(BOOL, at="%QX2.1")
    nKept = var(INT, retain=True)


class MAIN(Program):
    nCounter = var(INT, 7)
    nShared = Variable[int, int](INT, 2, section=Section.STATIC)


def test_variables_with_places_values_and_tasks() -> None:
    plc = PlcRuntime([Task("A", 1_000_000), Task("B", 2_000_000, [MAIN])], [GVL], project="P")
    file = symbol_file(plc)
    variables = {item.name: item for item in file.variables}
    assert variables["GVL.bOut"].declared.address == Address("Q", "X", 2, 1)
    assert variables["GVL.nKept"].declared.address == Address("R", "", 0)
    parts = variables["GVL.aParts"].declared
    assert (parts.initial_bytes(), parts.comment) == (b"\4\0\3\0", "all")
    assert (variables["MAIN.nCounter"].task, variables["MAIN.nCounter"].is_global) == (1, False)
    assert variables["MAIN.nShared"].declared.initial_bytes() == b"\2\0"
    assert (file.name, file.port, [task.name for task in file.tasks]) == ("P", 851, ["A", "B"])
    assert "ST_Part" in [type.name for type in file.types]
