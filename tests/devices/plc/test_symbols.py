"""Symbols of a PLC: addresses, values, parts, methods, tables."""
# ruff: noqa: N815 (IEC names)

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.devices.plc.symbols import PlcSymbol, PlcSymbols
from achse.iec import (
    ARRAY,
    BOOL,
    INT,
    STRING,
    FunctionBlock,
    GlobalVariables,
    Program,
    Struct,
    method,
    pointer_to,
    reference_to,
    var,
)
from achse.iec.datatypes import decode_types
from achse.iec.symbols import SymbolEntry, SymbolFlag, decode_symbols
from achse.iec.typetable import TypeTable
from achse.iec.variables import Section, Variable
from achse.native.memory import MemoryCell
from achse.plc import Area, PlcRuntime, Task


@pytest.fixture
def symbols(plc: PlcRuntime) -> PlcSymbols:
    return PlcSymbols(plc)


def symbol_named(symbols: PlcSymbols, name: str) -> PlcSymbol:
    symbol = symbols.resolve(name)
    assert symbol is not None, name
    return symbol


def instance(plc: PlcRuntime, name: str) -> Any:
    return next(unit.instance for unit in plc.units if unit.name == name)


@pytest.mark.parametrize(
    ("name", "group", "size"),
    [
        ("MAIN.nCounter", 0x4040, 4),
        ("main.NCOUNTER", 0x4040, 4),
        ("GVL.nOutput", 0xF030, 2),
        ("GVL.nFlag", 0x4020, 4),
        ("GVL.bInput", 0xF021, 1),
        ("GVL.nRetain", 0x4030, 4),
        ("GVL.nKept", 0x4040, 4),
    ],
)
def test_a_variable_is_found_in_any_case_in_its_group(
    symbols: PlcSymbols, name: str, group: int, size: int
) -> None:
    symbol = symbol_named(symbols, name)
    assert (symbol.index_group, symbol.size) == (group, size)


def test_fixed_addresses_are_index_offsets(symbols: PlcSymbols) -> None:
    assert symbol_named(symbols, "GVL.nOutput").index_offset == 4
    assert symbol_named(symbols, "GVL.nFlag").index_offset == 8
    assert symbol_named(symbols, "GVL.bInput").index_offset == 8 + 2


EVERYTHING = [
    "GVL.aGrid",
    "GVL.aGrid[1]",
    "GVL.aGrid[1,2]",
    "GVL.aPoints[2].sName",
    "GVL.aPoints[2].aTags[1]",
    "GVL.aPoints[1].bLow",
    "GVL.aPoints[1].bHigh",
    "GVL.aValues[-1]",
    "GVL.bInput",
    "GVL.fbSums[0].nCalls",
    "GVL.nFlag.8",
    "GVL.nOutput",
    "GVL.nRetain.31",
    "TwinCAT_SystemInfoVarList._TaskInfo[2].TaskName",
]


@pytest.mark.parametrize("name", EVERYTHING)
def test_handle_and_address_give_the_same_value_and_take_the_same_write(
    device: PlcDevice, symbols: PlcSymbols, name: str
) -> None:
    symbol = symbol_named(symbols, name)
    group, offset = symbol.index_group, symbol.index_offset
    before = symbol.read()
    assert len(before) == symbol.size
    assert device.read(group, offset, symbol.size) == before
    other = bytes((before[0] ^ 1,)) + before[1:]
    symbol.write(other)
    assert device.read(group, offset, symbol.size) == other
    device.write(group, offset, before)
    assert symbol.read() == before


def test_parts_have_the_values_declared(symbols: PlcSymbols) -> None:
    assert symbol_named(symbols, "GVL.aValues[-1]").read() == b"\x01\x00"
    assert symbol_named(symbols, "GVL.aValues[3]").read() == b"\x05\x00"
    assert symbol_named(symbols, "gvl.agrid[1, 2]").read() == b"\x06\x00"
    assert symbol_named(symbols, "GVL.aGrid[1][0]").read() == b"\x04\x00"
    assert symbol_named(symbols, "GVL.aPoints[2].nId").read() == b"\x07\x00"
    assert symbol_named(symbols, "GVL.aPoints[2].bHigh").read() == b"\x01"
    assert symbol_named(symbols, "GVL.nFlag.9").read() == b"\x01"
    assert symbol_named(symbols, "GVL.nFlag.8").read() == b"\x00"


def test_a_shorter_write_keeps_the_rest(symbols: PlcSymbols) -> None:
    symbol = symbol_named(symbols, "GVL.nFlag")
    symbol.write(b"\xff")
    assert symbol.read() == b"\xff\x02\x03\x04"


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "MAIN",
        "MAIN.",
        "MAIN.nope",
        "nope",
        "GVL.aValues[",
        "GVL.aGrid[0,0,0]",
        "GVL.nFlag.32",
        "GVL.nFlag.x",
        "GVL.nFlag^",
        "GVL.bInput.0",
        "GVL.fbSums[0]#Nothing",
        "GVL.aPoints[1]#Add",
        "x" * 10_000,
        "GVL" + ".a" * 5_000,
        "GVL.aValues" + "[1]" * 3_000,
    ],
)
def test_a_name_that_leads_nowhere_is_unknown(symbols: PlcSymbols, name: str) -> None:
    assert symbols.resolve(name) is None


@pytest.mark.parametrize(
    "name",
    [
        "GVL.aValues[4]",
        "GVL.aValues[-2]",
        "GVL.aValues[99999999999999999999]",
        "GVL.aPoints[3].fX",
        "GVL.aGrid[0,3]",
    ],
)
def test_an_index_out_of_bounds_has_its_own_code(device: PlcDevice, name: str) -> None:
    for group in (0xF003, 0xF004, 0xF007, 0xF009):
        with pytest.raises(DeviceError) as refusal:
            device.read_write(group, 0, 100, name.encode())
        assert refusal.value.return_code is ReturnCode.INVALID_ARRAY_INDEX


def test_a_constant_is_read_only_for_clients(device: PlcDevice, symbols: PlcSymbols) -> None:
    symbol = symbol_named(symbols, "GVL.nFixed")
    assert symbol.read_only
    assert SymbolEntry.decode(symbol.entry()).flags & SymbolFlag.READ_ONLY
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"GVL.nFixed\0"))[0]
    with pytest.raises(DeviceError) as refusal:
        device.write(0xF005, handle, b"\0\0")
    assert refusal.value.return_code is ReturnCode.INVALID_ACCESS


def test_an_entry_says_what_was_declared(symbols: PlcSymbols) -> None:
    values = SymbolEntry.decode(symbol_named(symbols, "gvl.avalues").entry())
    assert (values.name, values.type_name, values.size, values.comment) == (
        "GVL.aValues",
        "ARRAY [-1..3] OF INT",
        10,
        "five values",
    )
    fixed = SymbolEntry.decode(symbol_named(symbols, "GVL.nFixed").entry())
    assert fixed.attributes == (("Unit", "mm"),)
    output = SymbolEntry.decode(symbol_named(symbols, "GVL.nOutput").entry())
    assert output.attributes == (("TcAddressType", "Output"),)
    decoded = SymbolEntry.decode(symbol_named(symbols, "GVL.nKept").entry())
    assert decoded.flags & SymbolFlag.PERSISTENT
    bit = SymbolEntry.decode(symbol_named(symbols, "GVL.bInput").entry())
    assert bit.flags & SymbolFlag.BIT_VALUE
    assert (bit.type_name, bit.size) == ("BOOL", 1)
    part = SymbolEntry.decode(symbol_named(symbols, "GVL.aPoints[2].fX").entry())
    assert (part.name, part.type_name) == ("GVL.aPoints[2].fX", "LREAL")


def test_the_context_of_a_symbol_is_the_number_of_its_task(symbols: PlcSymbols) -> None:
    assert symbol_named(symbols, "MAIN.nCounter").context == 1
    assert symbol_named(symbols, "Slow.nSlow").context == 2
    assert symbol_named(symbols, "GVL.nFlag").context == 0, "no task owns a list"
    info = symbol_named(symbols, "TwinCAT_SystemInfoVarList._AppInfo")
    assert SymbolEntry.decode(info.entry()).flags == 0x0108, "as recorded"
    assert SymbolEntry.decode(symbol_named(symbols, "Slow.nSlow").entry()).context == 2


def test_the_tables_hold_every_variable_and_every_type(symbols: PlcSymbols) -> None:
    table = decode_symbols(symbols.symbol_table())
    info = symbols.upload_info()
    assert len(table) == info.symbol_count == len(symbols.plc.variables)
    names = [entry.name for entry in table]
    assert names == sorted(names, key=str.lower)
    types = decode_types(symbols.type_table())
    assert len(types) == info.type_count
    rebuilt = TypeTable(types)
    for entry in table:
        assert rebuilt.type(entry.type_name).size == entry.size
    for name in ("BOOL", "UDINT", "LREAL", "STRING(15)", "PLC.PlcTaskSystemInfo"):
        assert name in rebuilt


def test_a_type_is_described_by_name(symbols: PlcSymbols) -> None:
    entry = symbols.type_entry("st_point")
    assert entry is not None
    (point,) = decode_types(entry)
    assert [member.name for member in point.members] == [
        "nId",
        "fX",
        "sName",
        "aTags",
        "bLow",
        "bHigh",
    ]
    assert symbols.type_entry("ST_Nothing") is None


def call(device: PlcDevice, path: str, arguments: bytes, length: int) -> bytes:
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, path.encode()))[0]
    return device.read_write(0xF005, handle, length, arguments)


def test_a_method_runs_on_the_living_function_block(device: PlcDevice, plc: PlcRuntime) -> None:
    gvl = instance(plc, "GVL")
    answer = call(device, "GVL.fbSums[1]#Add", struct.pack("<dd", 1.5, 2.0), 12)
    assert struct.unpack("<dI", answer) == (3.5, 1)
    answer = call(device, "gvl.fbsums[1]#add", struct.pack("<dd", 1.0, 1.0), 12)
    assert struct.unpack("<dI", answer) == (2.0, 2)
    assert gvl.fbSums[1].nCalls == 2
    assert gvl.fbSums[1].history == [3.5, 2.0]
    assert gvl.fbSums[0].history == []
    assert call(device, "GVL.fbSums[1]#Clear", b"", 0) == b""
    assert gvl.fbSums[1].history == []


def test_a_method_with_wrong_arguments_is_refused(device: PlcDevice) -> None:
    with pytest.raises(DeviceError) as refusal:
        call(device, "GVL.fbSums[0]#Add", b"\0" * 15, 12)
    assert refusal.value.return_code is ReturnCode.INVALID_SIZE


def test_a_handle_comes_with_size_and_type_on_request(device: PlcDevice) -> None:
    answer = device.read_write(0xF003, 0, 0xFFFF_FFFF, b"GVL.nFlag\0")
    _, size, adst, length = struct.unpack_from("<IIIH", answer)
    assert (size, adst, length, answer[14:]) == (4, 19, 5, b"UDINT\0")


def test_an_online_change_outdates_handles_and_counts(device: PlcDevice, plc: PlcRuntime) -> None:
    def online_changes() -> bytes:
        name = b"TwinCAT_SystemInfoVarList._AppInfo.OnlineChangeCnt"
        return device.read_write(0xF004, 0, 4, name)

    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"MAIN.nCounter"))[0]
    (version,) = device.read(0xF008, 0, 1)
    assert online_changes() == b"\0\0\0\0"
    plc.online_change()
    assert device.read(0xF008, 0, 1) == bytes([version + 1 & 0xFF])
    assert online_changes() == b"\x01\0\0\0"
    with pytest.raises(DeviceError) as refusal:
        device.read(0xF005, handle, 4)
    assert refusal.value.return_code is ReturnCode.SYMBOL_VERSION_INVALID
    plc.reset()
    assert online_changes() == b"\x01\0\0\0"


class ST_Node(Struct):  # noqa: N801
    nValue = var(INT)
    aMore = var(ARRAY(INT, (1, 3)))


class FB_Node(FunctionBlock):  # noqa: N801
    nOwn = var(INT)
    nShared = Variable[int, int](INT, 9, section=Section.STATIC)

    @method(INT, nA=INT)
    def Fail(self, a: int) -> int:  # noqa: N802
        raise ValueError("no such thing")


class Pointing(GlobalVariables, name="P"):
    stNode = var(ST_Node, {"nValue": 5, "aMore": [1, 2, 3]})
    pNode = var(pointer_to(ST_Node))
    rNode = var(reference_to(ST_Node))
    ppNode = var(pointer_to(pointer_to(ST_Node)))
    nFlag = var(INT, 8, at="%MW6")
    pFlag = var(pointer_to(INT))
    fbA = var(FB_Node)
    fbB = var(FB_Node)


@pytest.fixture
def pointing() -> tuple[PlcRuntime, PlcDevice]:
    plc = PlcRuntime([Task()], [Pointing])
    return plc, PlcDevice(plc, clock=lambda: 0)


def _address(plc: PlcRuntime, name: str) -> int:
    placed = next(placed for placed in plc.variables if placed.name == name)
    return plc.memory.address(placed.area, placed.offset)


def test_a_pointer_is_followed_each_time(pointing: tuple[PlcRuntime, PlcDevice]) -> None:
    plc, device = pointing
    gvl = plc.unit(Pointing)
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"p.pnode^.amore[2]"))[0]
    with pytest.raises(DeviceError) as refusal:
        device.read(0xF005, handle, 2)
    assert refusal.value.return_code is ReturnCode.SYMBOL_NOT_ACTIVE
    gvl.pNode = _address(plc, "P.stNode")
    assert device.read(0xF005, handle, 2) == b"\x02\0"
    device.write(0xF005, handle, b"\x07\0")
    assert gvl.stNode.aMore == [1, 7, 3]
    gvl.rNode, gvl.ppNode = gvl.pNode, _address(plc, "P.pNode")
    gvl.pFlag = _address(plc, "P.nFlag")
    assert device.read_write(0xF004, 0, 2, b"P.rNode.nValue") == b"\x05\0"
    assert device.read_write(0xF004, 0, 2, b"P.ppNode^^.nValue.0") == b"\x01"
    assert device.read_write(0xF004, 0, 2, b"P.pFlag^") == b"\x08\0"
    group, offset, size = struct.unpack("<III", device.read_write(0xF007, 0, 12, b"P.pFlag^"))
    assert (group, offset, size) == (0x4020, 6, 2)


class ST_Inner(Struct):  # noqa: N801
    nValue = var(INT)


class ST_Kept(Struct):  # noqa: N801
    stInner = var(ST_Inner)


class ST_Other(Struct):  # noqa: N801
    nValue = var(INT)


class Keeping(GlobalVariables, name="K"):
    stKept = var(ST_Kept, persistent=True, attributes={"x": "y"})
    stOther = var(ST_Other)


def test_persistent_variables_and_their_types_have_the_flags_of_it() -> None:
    symbols = PlcSymbols(PlcRuntime([Task()], [Keeping]))
    flags = {entry.name: entry.flags for entry in decode_types(symbols.type_table())}
    assert [flags[name] for name in ("ST_Kept", "ST_Inner", "ST_Other")] == [
        0x20_0081,
        0x20_0081,
        0x81,
    ]
    assert SymbolEntry.decode(symbol_named(symbols, "K.stKept").entry()).flags == 0x1009
    (alone,) = decode_types(symbols.type_entry("ST_Kept") or b"")
    assert alone.flags == 0x20_0081


class Referring(GlobalVariables, name="R"):
    nValue = var(INT, 5)
    rValue = var(reference_to(INT))
    stNode = var(ST_Node, {"nValue": 6})
    rNode = var(reference_to(ST_Node))


def test_a_reference_by_name_is_what_it_refers_to() -> None:
    plc = PlcRuntime([Task()], [Referring])
    device = PlcDevice(plc, clock=lambda: 0)
    gvl = plc.unit(Referring)
    with pytest.raises(DeviceError) as refusal:
        device.read_write(0xF004, 0, 2, b"R.rValue")
    assert refusal.value.return_code is ReturnCode.SYMBOL_NOT_ACTIVE
    gvl.rValue, gvl.rNode = _address(plc, "R.nValue"), _address(plc, "R.stNode")
    assert device.read_write(0xF004, 0, 100, b"r.rvalue") == b"\x05\0"
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"R.rValue"))[0]
    device.write(0xF005, handle, b"\x07\0")
    assert gvl.nValue == 7
    for name, target in (("R.rValue", "R.nValue"), ("R.rNode", "R.stNode")):
        entry, meant = (
            SymbolEntry.decode(device.read_write(0xF009, 0, 1000, text.encode()))
            for text in (name, target)
        )
        assert (entry.type_name, entry.size, entry.index_offset, entry.guid) == (
            meant.type_name,
            meant.size,
            meant.index_offset,
            meant.guid,
        )
        assert device.read_write(0xF007, 0, 12, name.encode())[8:] == meant.size.to_bytes(
            4, "little"
        )


class ST_Texts(Struct):  # noqa: N801
    sName = var(STRING(20), attributes={"TcEncoding": "UTF-8", "Unit": "x"}, comment=" a name")
    aNames = var(ARRAY(STRING(20), (0, 1)), attributes={"TcEncoding": "UTF-8", "Unit": "x"})
    sPlain = var(STRING(20))


class Texts(GlobalVariables, name="T"):
    aTexts = var(ARRAY(ST_Texts, (0, 1)))
    aNames = var(ARRAY(STRING(20), (0, 1)), attributes={"TcEncoding": "UTF-8"})


@pytest.mark.parametrize(
    ("name", "attributes", "comment"),
    [
        ("T.aTexts[1].sName", {"TcEncoding": "UTF-8", "Unit": "x"}, " a name"),
        ("T.aTexts[0].aNames", {"TcEncoding": "UTF-8", "Unit": "x"}, ""),
        ("T.aTexts[0].aNames[1]", {"TcEncoding": "UTF-8"}, ""),
        ("T.aNames[1]", {"TcEncoding": "UTF-8"}, ""),
        ("T.aTexts[0].sPlain", {}, ""),
        ("T.aTexts[0]", {}, ""),
    ],
)
def test_the_entry_of_a_part_reports_its_attributes(
    name: str, attributes: dict[str, str], comment: str
) -> None:
    symbol = symbol_named(PlcSymbols(PlcRuntime([Task()], [Texts])), name)
    entry = SymbolEntry.decode(symbol.entry())
    assert dict(entry.attributes) == attributes
    assert entry.comment == comment
    assert bool(entry.flags & SymbolFlag.ATTRIBUTES) is bool(attributes)


@pytest.mark.parametrize("address", [0, 1, 0x0FFF_FFFF, 0x5FFF_FFFF, 0xFFFF_FFFF_FFFF_FFFF])
def test_a_pointer_to_nowhere_harms_no_other(
    pointing: tuple[PlcRuntime, PlcDevice], address: int
) -> None:
    plc, device = pointing
    plc.unit(Pointing).pNode = address
    for group in (0xF004, 0xF007, 0xF009):
        with pytest.raises(DeviceError) as refusal:
            device.read_write(group, 0, 100, b"P.pNode^")
        assert refusal.value.return_code is ReturnCode.SYMBOL_NOT_ACTIVE


def test_a_static_variable_is_reached_by_its_type_and_by_each_instance(
    pointing: tuple[PlcRuntime, PlcDevice],
) -> None:
    plc, device = pointing
    plc.unit(Pointing).fbB.nShared = 11
    names = (b"P.fbA.nShared", b"P.fbB.nShared", b"FB_Node.nShared")
    assert [device.read_write(0xF004, 0, 2, name) for name in names] == 3 * [b"\x0b\0"]
    places = {device.read_write(0xF007, 0, 12, name) for name in names}
    assert len(places) == 1


def test_a_method_that_fails_is_a_device_error(
    pointing: tuple[PlcRuntime, PlcDevice], caplog: pytest.LogCaptureFixture
) -> None:
    _, device = pointing
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"P.fbA#Fail"))[0]
    with pytest.raises(DeviceError) as refusal:
        device.read_write(0xF005, handle, 2, b"\0\0")
    assert refusal.value.return_code is ReturnCode.DEVICE_ERROR
    assert "no such thing" in caplog.text


def test_other_declarations_have_another_version() -> None:
    def version(*declared: type[GlobalVariables]) -> int:
        return PlcSymbols(PlcRuntime([Task()], declared)).version

    assert version(Pointing) == version(Pointing)
    assert version(Pointing) != version()


def test_an_online_change_shows_the_new_symbols(pointing: tuple[PlcRuntime, PlcDevice]) -> None:
    plc, device = pointing
    before = device.read(0xF00B, 0, 0xFFFFFF)

    class More(GlobalVariables, name="P"):
        nAdded = var(INT, 3)

    plc.online_change([More])
    names = [entry.name for entry in decode_symbols(device.read(0xF00B, 0, 0xFFFFFF))]
    assert "P.nAdded" in names
    assert "P.stNode" not in names
    assert len(before) != len(device.read(0xF00B, 0, 0xFFFFFF))
    assert device.read_write(0xF004, 0, 2, b"P.nAdded") == b"\x03\0"


def test_a_long_or_foreign_text_does_not_stop_the_upload() -> None:
    class Texts(GlobalVariables):
        nA = var(INT, comment="Δ" * 70_000, attributes={"note": "→" * 300, "ö" * 300: ""})

    table = PlcSymbols(PlcRuntime([Task()], [Texts])).symbol_table()
    (entry,) = [entry for entry in decode_symbols(table) if entry.name == "Texts.nA"]
    assert entry.comment == "?" * 0xFFFF
    assert entry.attributes == (("note", "?" * 255), ("ö" * 255, ""))


@given(zeros=st.integers(0, 3000), blanks=st.integers(0, 3000), index=st.integers(0, 4))
def test_name_of_an_element_does_not_grow_with_zeros_and_blanks(
    zeros: int, blanks: int, index: int
) -> None:
    class LISTED(Program):
        aValues = var(ARRAY(INT, (0, 4)))

    plc = PlcRuntime([Task("PlcTask", 10_000_000, [LISTED])])
    text = f"LISTED.aValues[{' ' * blanks}{'0' * zeros}{index}]"
    symbol = PlcSymbols(plc).resolve(text)
    assert symbol is not None
    assert len(symbol.name) <= 300
    assert symbol.index_offset == PlcSymbols(plc).resolve(f"LISTED.aValues[{index}]").index_offset  # type: ignore[union-attr]


def test_member_with_tcnosymbol_is_not_shown() -> None:
    class Inner(FunctionBlock):
        nInner = var(INT)

    class Outer(FunctionBlock):
        nShown = var(INT)
        fbHidden = var(Inner, attributes={"TcNoSymbol": ""})
        nLast = var(INT)

    class Hiding(GlobalVariables):
        fbOuter = var(Outer)
        nAway = var(INT, attributes={"tcnosymbol": ""})

    symbols = PlcSymbols(PlcRuntime([Task()], [Hiding]))
    assert symbol_named(symbols, "Hiding.fbOuter.nLast").size == 2
    for name in (
        "Hiding.nAway",
        "Hiding.fbOuter.fbHidden",
        "Hiding.fbOuter.fbHidden.nInner",
    ):
        assert symbols.resolve(name) is None
    names = {entry.name for entry in decode_symbols(symbols.symbol_table())}
    assert "HIDING.NAWAY" not in {name.upper() for name in names}
    types = {entry.name: entry for entry in decode_types(symbols.type_table())}
    assert "Inner" not in types
    assert [member.name for member in types["Outer"].members] == ["nShown", "nLast"]
    assert types["Outer"].members[1].offset == 32


def test_table_has_the_entry_of_each_variable(symbols: PlcSymbols) -> None:
    table = symbols.symbol_table()
    for entry in decode_symbols(table):
        assert symbol_named(symbols, entry.name).entry() in table
    flags = {entry.name: entry.flags & ~SymbolFlag.TYPE_GUID for entry in decode_symbols(table)}
    assert flags["GVL.bInput"] == SymbolFlag.BIT_VALUE | SymbolFlag.ATTRIBUTES
    assert flags["GVL.nFixed"] == SymbolFlag.READ_ONLY | SymbolFlag.ATTRIBUTES
    assert flags["Slow.nSlow"] == 0x200


def test_bit_is_written_without_its_neighbours(plc: PlcRuntime, symbols: PlcSymbols) -> None:
    plc.memory[Area.FLAG].write(8, b"\xff\xff\0\0")
    symbol_named(symbols, "GVL.nFlag.9").write(b"\0")
    symbol_named(symbols, "GVL.nFlag.20").write(b"\1")
    assert plc.memory[Area.FLAG].read(8, 4) == b"\xff\xfd\x10\0"


def test_part_at_a_fixed_place_is_read_from_memory_at_once(symbols: PlcSymbols) -> None:
    for name in ("GVL.aGrid[1,2]", "GVL.aPoints[2].fX", "MAIN.nCounter"):
        assert isinstance(symbol_named(symbols, name).read, MemoryCell)


def test_static_variable_is_of_the_first_task(pointing: tuple[PlcRuntime, PlcDevice]) -> None:
    plc, _ = pointing
    symbol = symbol_named(PlcSymbols(plc), "FB_Node.nShared")
    flags = SymbolEntry.decode(symbol.entry()).flags
    assert (symbol.context, flags & SymbolFlag.STATIC) == (1, SymbolFlag.STATIC)


@pytest.mark.parametrize(
    ("length", "name"), [(256, "GVL.aValues[" + " " * 253 + "1]"), (257, "GVL.aValues[1]")]
)
def test_symbol_has_the_spelling_of_the_client_up_to_256_characters(
    symbols: PlcSymbols, length: int, name: str
) -> None:
    part = "[" + "1]".rjust(length - 1)
    assert symbol_named(symbols, f"gvl.AVALUES{part}").name == name


def test_variable_at_another_bit_has_another_version() -> None:
    def version(address: str) -> int:
        class Inputs(GlobalVariables, name="I"):
            bA = var(BOOL, at=address)

        return PlcSymbols(PlcRuntime([Task()], [Inputs])).version

    assert len({version(f"%IX3.{bit}") for bit in range(4)}) == 4
