""".tmc read: types with the file's layout, variables at their places, located faults."""

import contextlib
import random
from datetime import timedelta

import pytest

from achse.iec import ArrayType, EnumType, InterfaceType, StructType, SubrangeType, plain
from achse.iec.derived import OpaqueType
from achse.iec.structs import RecordKind
from achse.iec.variables import Address, Section
from achse.st.lexis.source import SourceError
from achse.st.symbolfiles import SymbolFile, read_tmc
from achse.st.symbolfiles.library import LibraryTypes


@pytest.fixture
def file(tmc: bytes) -> SymbolFile:
    return read_tmc(tmc, "plant.tmc")


def _type(file: SymbolFile, name: str) -> object:
    return next(type for type in file.types if type.name == name)


def test_name_port_platform_and_tasks(file: SymbolFile) -> None:
    assert (file.name, file.port, file.pointer_size) == ("Plant", 853, 8)
    assert [(t.name, t.cycle_ns, t.priority) for t in file.tasks] == [
        ("FastTask", 2_000_000, 5),
        ("SlowTask", 10_000_000, 20),
    ]


def test_variables_lie_where_the_file_says(file: SymbolFile) -> None:
    places = {item.name: (item.declared.address, item.task) for item in file.variables}
    assert places == {
        "MAIN.fbMotor.bRun": (Address("I", "", 1000), 1),
        "MAIN.bBit": (Address("I", "X", 1001, 3), 1),
        "GVL.aAxes": (Address("D", "", 512), 0),
        "MAIN.fbMotor": (Address("D", "", 1024), 0),
        "MAIN.nLimited": (Address("D", "", 1040), 0),
        "MAIN.itf": (Address("D", "", 1048), 0),
        "TwinCAT_SystemInfoVarList._AppInfo": (Address("D", "", 1056), 0),
    }


def test_a_structure_keeps_the_offsets_of_the_file_and_inherits(file: SymbolFile) -> None:
    axis = _type(file, "ST_Axis")
    assert isinstance(axis, StructType)
    assert axis.size == 64
    assert [(m.name, m.type.name, m.offset) for m in axis.members] == [
        ("fPos", "LREAL", 0),
        ("aGrid", "ARRAY [1..2] OF ARRAY [-1..1] OF INT", 8),
        ("eState", "E_State", 20),
        ("sName", "Lib.T_Text", 22),
        ("pNext", "POINTER TO ST_Axis", 40),
        ("tWait", "TIME", 48),
    ]
    assert axis.member("sName").comment == " its name"


def test_initial_values_of_members_and_of_parts_of_variables(file: SymbolFile) -> None:
    declared = next(item.declared for item in file.variables if item.name == "GVL.aAxes")
    assert isinstance(declared.type, ArrayType)
    first, second = (plain(value) for value in declared.type.decode(declared.initial_bytes()))
    assert first == {
        "fPos": 1.5,
        "aGrid": [[0, 0, 0], [7, 0, 0]],
        "eState": 10,
        "sName": "it's",
        "pNext": 0,
        "tWait": timedelta(minutes=1),
    }
    # The second element's state is source text the file does not explain.
    assert second == {**first, "fPos": 2.5}


def test_enumeration_subrange_alias_and_interface(file: SymbolFile) -> None:
    state = _type(file, "E_State")
    assert isinstance(state, EnumType)
    assert (state.base.name, state.numbers) == ("UINT", {"Idle": 0, "Busy": 10})
    assert (state.comment, state.comments) == (" what it does ", {"Busy": "works"})
    limited = _type(file, "UINT (2..GVL.MOST)")
    assert isinstance(limited, SubrangeType)
    assert (limited.low, limited.high) == (2, 100)
    assert isinstance(_type(file, "I_Motor"), InterfaceType)


def test_bit_members_and_guids(file: SymbolFile) -> None:
    info = _type(file, "PLC.Info")
    assert isinstance(info, StructType)
    assert info.guid.hex() == "7ff48f5c837f93448d21f1ff8a08f75a"
    ready = info.member("bReady")
    assert (ready.offset, ready.bit) == (4, 1)
    app_info = file.variables[-1].declared
    assert app_info.type is info  # the reference names the GUID only


def test_function_blocks_with_sections_statics_and_rpc_methods(file: SymbolFile) -> None:
    motor = _type(file, "FB_Motor")
    assert isinstance(motor, StructType)
    assert motor.kind is RecordKind.FUNCTION_BLOCK
    speed, count = motor.members
    assert (speed.section, dict(speed.attributes)) == (Section.INPUT, {"unit": "mm/s"})
    assert count.section is Section.STATIC
    (start,) = motor.methods  # only those with RpcEnable can be called
    assert start.name == "Start"
    assert [(p.name, p.type.name, p.is_output, p.by_reference) for p in start.parameters] == [
        ("fTarget", "LREAL", False, False),
        ("stUsed", "ST_Base", True, True),
    ]
    assert start.returns is not None
    assert start.returns.name == "BOOL"


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("<BitOffs>8192<", "<BitOffs>x<", "<BitOffs>: expected a whole number, got 'x'"),
        ("<BitOffs>8192<", "<BitOffs>99999999999<", "lies beyond byte 268435456"),
        ("<BitSize>512<", "<BitSize>400<", "member 'tWait' ends at 52 of 50 bytes"),
        ("<Name>eState</Name>", "<Name>FPOS</Name>", "two members are named 'FPOS'"),
        ("<BitOffs>160<", "<BitOffs>161<", "begins inside a byte"),
        ("<Enum>0<", "<Enum>70000<", "E_State.Idle = 70000 is not a UINT"),
        ("<Type>LREAL</Type>", "<Type>ST_Axis</Type>", "contains itself"),
        ('F1FF8A08F75A}" N', 'F1FF}" N', "expected a GUID"),
        ("TcModuleClass", "PlcProjectInfo", "expected <TcModuleClass>"),
    ],
)
def test_a_fault_is_named_with_file_and_line(tmc: bytes, old: str, new: str, fault: str) -> None:
    text = tmc.decode()
    assert old in text
    with pytest.raises(SourceError) as error:
        read_tmc(text.replace(old, new).encode(), "plant.tmc")
    assert str(error.value).startswith("plant.tmc:")
    assert fault in str(error.value)
    assert error.value.faults[0].location.line > 0


def test_bits_of_a_terminal_that_begin_inside_a_byte_are_left_out(tmc: bytes) -> None:
    old = "<Name>bReady</Name>"
    new = f"""<Name>nCycle</Name><Type GUID="{{18071995-0000-0000-0000-000000000011}}">BIT2</Type>
        <BitSize>2</BitSize><BitOffs>34</BitOffs></SubItem><SubItem>{old}"""
    assert tmc.decode().count(old) == 1
    names = [type.name for type in read_tmc(tmc, "plant.tmc").types]
    changed = read_tmc(tmc.decode().replace(old, new).encode(), "plant.tmc")
    assert [type.name for type in changed.types] == names
    members = [
        each.name for type in changed.types if isinstance(type, StructType) for each in type.members
    ]
    assert "bReady" in members
    assert "nCycle" not in members


def test_a_file_without_module_has_types_only(tmc: bytes) -> None:
    text = tmc.decode()
    start, end = text.index("<Modules>"), text.index("</Modules>") + len("</Modules>")
    for modules in ("", "<Modules/>", "<Modules></Modules>"):
        data = (text[:start] + modules + text[end:]).encode()
        file = read_tmc(data, "events.tmc")
        assert not file.variables
        assert _type(file, "ST_Axis")
        assert LibraryTypes([(data, "events.tmc")]).type("ST_Axis") is not None


def test_of_several_modules_the_one_of_the_plc_counts(tmc: bytes) -> None:
    text = tmc.decode().replace("<Modules>", "<Modules><Module><Name>Cpp</Name></Module>")
    assert read_tmc(text.encode(), "plant.tmc").name == "Plant"


def test_implausible_array_is_its_bytes(tmc: bytes) -> None:
    text = tmc.decode().replace("<Elements>2<", "<Elements>99999999999<")
    grid = read_tmc(text.encode(), "f.tmc").types[5]
    assert isinstance(grid, StructType)
    assert isinstance(grid.member("aGrid").type, OpaqueType)


def test_mutilated_files_give_located_errors_only(tmc: bytes) -> None:
    chance = random.Random(7)
    for _ in range(300):
        data = bytearray(tmc)
        for _ in range(chance.randrange(1, 6)):
            start = chance.randrange(len(data))
            kind = chance.randrange(4)
            if kind == 0:
                del data[start : start + chance.randrange(40)]
            elif kind == 1:
                data[start] = chance.randrange(256)
            elif kind == 2:
                end = start + chance.randrange(200)
                data[start:start] = data[start:end]
            else:
                data[start:start] = chance.choice([b"9999999", b"-1", b"<", b"STRING(", b"ARRAY ["])
        with contextlib.suppress(SourceError):
            read_tmc(bytes(data), "f.tmc").units()
