# ruff: noqa: N801, N815 -- IEC names carry their prefix
"""Units made of the variables of a symbol file; files made of what a target uploads."""

from achse.iec import INT, LREAL, Address, GlobalVariables, Program, Struct, Variable, iec_type, var
from achse.iec.describe import describe_type
from achse.iec.symbols import SymbolEntry, SymbolFlag
from achse.iec.typetable import TypeTable
from achse.st.symbolfiles import FileVariable, SymbolFile, read_tmc, units_of


class ST_Point(Struct):
    fX = var(LREAL)


def _variable(name: str, at: str, is_global: bool = False) -> FileVariable:
    return FileVariable(name, Variable(INT, name=name, at=at), is_global=is_global)


def test_a_unit_for_each_first_name_with_its_variables() -> None:
    units = units_of(
        [
            _variable("MAIN.a", "%MW2"),
            _variable("GVL.x", "%QW0", is_global=True),
            _variable("main.fb.q", "%QW4"),
            _variable("MAIN.A", "%MW8"),
            _variable(".bare", "%MW6", is_global=True),
        ]
    )
    assert [(unit.__iec__.name, [m.name for m in unit.__iec__.members]) for unit in units] == [
        ("MAIN", ["a", "fb.q"]),
        ("GVL", ["x"]),
        ("", ["bare"]),
    ]
    assert issubclass(units[0], Program)
    assert issubclass(units[1], GlobalVariables)
    assert all(member.apart for unit in units for member in unit.__iec__.members)


def test_the_list_about_the_system_is_left_to_the_plc(tmc: bytes) -> None:
    names = [unit.__iec__.name for unit in read_tmc(tmc, "plant.tmc").units()]
    assert names == ["MAIN", "GVL"]


def test_a_file_of_what_a_target_uploads() -> None:
    point = iec_type(ST_Point)
    entries = [
        SymbolEntry.of("GVL.stP", point, 0x4040, 16, comment="c", flags=SymbolFlag.READ_ONLY),
        SymbolEntry.of("MAIN.bIn", INT, 0xF020, 4, context=2),
        SymbolEntry.of("Axes.X", LREAL, 0x4101, 0xA),
    ]
    file = SymbolFile.of_target("T", entries, TypeTable([describe_type(point)]), port=852)
    first, second = file.variables
    assert (first.name, first.declared.address) == ("GVL.stP", Address("D", "", 16))
    assert (first.declared.constant, first.declared.comment) == (True, "c")
    assert first.declared.type.guid == point.guid
    assert (second.declared.address, second.task) == (Address("I", "", 4), 1)
    assert len(file.tasks) == 2
    assert [type.name for type in file.types] == ["ST_Point"]
