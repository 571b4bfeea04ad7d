"""Methods and properties that sources declare and Python carries out, as clients reach them."""
# ruff: noqa: N801, N802 (IEC names)

import struct
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.iec.datatypes import DataTypeEntry
from achse.iec.symbols import SymbolEntry, SymbolFlag
from achse.plc import PlcRuntime, Task
from achse.plc.behaviour import with_behaviour
from achse.st.declare import declare
from achse.st.syntax.parser import parse

SOURCE = """
FUNCTION_BLOCK FB_Base
VAR nSpeed : INT := 5; sName : STRING(8) := 'left'; END_VAR
{attribute 'TcRpcEnable'} METHOD First : INT END_METHOD
{attribute 'TcRpcEnable'} METHOD Second : INT VAR_INPUT nA : INT; END_VAR END_METHOD
{attribute 'monitoring' := 'call'} PROPERTY Speed : INT GET END_GET SET END_SET END_PROPERTY
{attribute 'monitoring' := 'call'} PROPERTY Twice : INT GET END_GET END_PROPERTY
{attribute 'monitoring' := 'call'} PROPERTY Name : STRING(8) GET END_GET SET END_SET END_PROPERTY
{attribute 'monitoring' := 'call'} PROPERTY Target : REFERENCE TO INT GET END_GET END_PROPERTY
{attribute 'monitoring' := 'call'} PROPERTY Bodiless : INT GET END_GET END_PROPERTY
PROPERTY Hidden : INT GET END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_More EXTENDS FB_Base
{attribute 'TcRpcEnable'} METHOD FIRST : DINT VAR_INPUT nB : DINT; END_VAR END_METHOD
{attribute 'TcRpcEnable'} METHOD Third : INT END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Outer
VAR aInner : ARRAY [0..1] OF FB_Base; END_VAR VAR_STAT fbStatic : FB_Base; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR nCount : INT := 3; aBlocks : ARRAY [1..2] OF FB_More; nOut AT %QW2 : INT; END_VAR
{attribute 'TcRpcEnable'} METHOD Add : DINT VAR_INPUT nA : DINT; END_VAR VAR_OUTPUT nNow : INT; END_VAR
END_METHOD
{attribute 'monitoring' := 'call'} PROPERTY Count : INT GET END_GET SET END_SET END_PROPERTY
END_PROGRAM
PROGRAM Called
{attribute 'TcRpcEnable'} METHOD First : INT END_METHOD
END_PROGRAM
PROGRAM Monitored
{attribute 'monitoring' := 'call'} PROPERTY Count : INT GET END_GET END_PROPERTY
END_PROGRAM
PROGRAM Outer VAR fbOuter : FB_Outer; END_VAR END_PROGRAM
PROGRAM Plain VAR n : INT; END_VAR END_PROGRAM
"""  # noqa: E501


class MAIN:
    nCount: int  # noqa: N815

    def add(self, number: int) -> tuple[int, int]:
        self.nCount += 1
        return number + 1, self.nCount

    @property
    def Count(self) -> int:
        return self.nCount

    @Count.setter
    def Count(self, value: int) -> None:
        self.nCount = value


class FB_Base:
    nSpeed: int  # noqa: N815
    sName: str  # noqa: N815

    def First(self) -> int:
        return 1

    def Second(self, a: int) -> int:
        return 2 * a

    @property
    def speed(self) -> int:
        return self.nSpeed

    @speed.setter
    def speed(self, value: int) -> None:
        if value < 0:
            raise ValueError("backwards")
        self.nSpeed = value

    @property
    def Twice(self) -> int:
        return 2 * self.nSpeed

    @property
    def Name(self) -> str:
        return self.sName

    @Name.setter
    def Name(self, value: str) -> None:
        self.sName = value


class FB_More:
    def First(self, b: int) -> int:
        return 10 * b

    def Third(self) -> int:
        return 3


@pytest.fixture
def device() -> PlcDevice:
    declared = declare([parse(SOURCE)])
    units = with_behaviour(declared.units, [MAIN, FB_Base, FB_More], declared.types.values())
    return PlcDevice(PlcRuntime([Task()], units), clock=lambda: 0)


def handle(device: PlcDevice, name: str) -> int:
    result: int = struct.unpack("<I", device.read_write(0xF003, 0, 4, name.encode()))[0]
    return result


def call(device: PlcDevice, path: str, data: bytes = b"", length: int = 64) -> bytes:
    return device.read_write(0xF005, handle(device, path), length, data)


def refused(what: Any, *arguments: Any) -> ReturnCode:
    with pytest.raises(DeviceError) as caught:
        what(*arguments)
    code = caught.value.return_code
    assert code is not None
    return code


# methods ------------------------------------------------------------------------------------------


def test_a_method_of_a_program_is_called_by_the_name_of_the_program(device: PlcDevice) -> None:
    assert call(device, "MAIN#Add", struct.pack("<i", 41)) == struct.pack("<ih", 42, 4)
    assert call(device, "main#ADD", struct.pack("<i", 0)) == struct.pack("<ih", 1, 5)
    assert device.read_write(0xF004, 0, 2, b"MAIN.nCount") == struct.pack("<h", 5)
    assert refused(call, device, "MAIN#Add", b"\0") == ReturnCode.INVALID_SIZE
    assert refused(handle, device, "MAIN#None") == ReturnCode.SYMBOL_NOT_FOUND


def test_a_program_with_methods_is_a_symbol_whose_type_says_them(device: PlcDevice) -> None:
    symbol = SymbolEntry.decode(device.read_write(0xF009, 0, 0xFFFF, b"main"))
    assert (symbol.name, symbol.type_name) == ("MAIN", "MAIN")
    assert symbol.flags & SymbolFlag.READ_ONLY
    assert refused(device.write, symbol.index_group, 0xFFFF_FFFF, b"\0")
    entry = DataTypeEntry.decode(device.read_write(0xF011, 0, 0xFFFF, b"MAIN"))
    assert [method.name for method in entry.methods] == ["Add"]
    # What is at an address of its own is no part of the program's memory.
    assert [member.name for member in entry.members] == ["nCount", "aBlocks"]
    assert device.read_write(0xF004, 0, 0xFFFF, b"MAIN")[:2] == struct.pack("<h", 3)
    assert refused(handle, device, "Plain") == ReturnCode.SYMBOL_NOT_FOUND


def test_an_overriding_method_has_the_place_of_the_one_it_overrides(device: PlcDevice) -> None:
    entry = DataTypeEntry.decode(device.read_write(0xF011, 0, 0xFFFF, b"FB_More"))
    assert [(one.name, one.table_index) for one in entry.methods] == [
        ("FIRST", 0),
        ("Second", 1),
        ("Third", 2),
    ]
    assert entry.methods[0].return_type == "DINT"
    path = "MAIN.aBlocks[2]"
    assert call(device, f"{path}#First", struct.pack("<i", 7)) == struct.pack("<i", 70)
    assert call(device, f"{path}#Second", struct.pack("<h", 7)) == struct.pack("<h", 14)
    assert call(device, f"{path}#Third") == struct.pack("<h", 3)


# properties ---------------------------------------------------------------------------------------


def test_a_property_is_read_and_written_by_handle(device: PlcDevice) -> None:
    speed = handle(device, "MAIN.aBlocks[2].SPEED")
    assert device.read(0xF005, speed, 2) == struct.pack("<h", 5)
    device.write(0xF005, speed, struct.pack("<h", 9))
    assert device.read_write(0xF004, 0, 2, b"MAIN.aBlocks[2].nSpeed") == struct.pack("<h", 9)
    assert device.read_write(0xF004, 0, 2, b"MAIN.aBlocks[2].Twice") == struct.pack("<h", 18)
    assert device.read_write(0xF004, 0, 2, b"MAIN.aBlocks[1].Twice") == struct.pack("<h", 10)
    count = handle(device, "MAIN.Count")
    device.write(0xF005, count, struct.pack("<h", 70))
    assert device.read_write(0xF004, 0, 2, b"MAIN.nCount") == struct.pack("<h", 70)


def test_a_shorter_write_keeps_the_rest_of_a_property(device: PlcDevice) -> None:
    name = handle(device, "MAIN.aBlocks[1].Name")
    device.write(0xF005, name, b"ri")
    assert device.read(0xF005, name, 9) == b"rift\0\0\0\0\0"
    device.write(0xF005, name, b"up\0")
    assert device.read(0xF005, name, 9).startswith(b"up\0")


def test_the_entry_of_a_property_bears_its_index_group(device: PlcDevice) -> None:
    entry = SymbolEntry.decode(device.read_write(0xF009, 0, 0xFFFF, b"MAIN.aBlocks[1].Speed"))
    assert (entry.index_group, entry.type_name, entry.size) == (0xF019, "INT", 2)
    assert dict(entry.attributes) == {"monitoring": "call"}
    assert struct.unpack("<III", device.read_write(0xF007, 0, 12, b"MAIN.Count"))[0] == 0xF019
    # Reached by handle only.
    assert refused(device.read, 0xF019, entry.index_offset, 2)


@pytest.mark.parametrize(
    ("name", "data", "code"),
    [
        ("Twice", b"\1\0", ReturnCode.INVALID_ACCESS),
        ("Speed", b"\xff\xff", ReturnCode.DEVICE_ERROR),
        ("Speed", b"\1\0\0", ReturnCode.INVALID_SIZE),
    ],
)
def test_what_a_property_refuses(
    device: PlcDevice, name: str, data: bytes, code: ReturnCode
) -> None:
    result = handle(device, f"MAIN.aBlocks[1].{name}")
    assert refused(device.write, 0xF005, result, data) == code
    assert device.read_write(0xF004, 0, 2, b"MAIN.aBlocks[1].nSpeed") == struct.pack("<h", 5)


def test_a_property_without_a_body_or_out_of_sight(device: PlcDevice) -> None:
    bodiless = handle(device, "MAIN.aBlocks[1].Bodiless")
    assert refused(device.read, 0xF005, bodiless, 2) == ReturnCode.SERVICE_NOT_SUPPORTED
    for name in ("Hidden", "Speed.x", "Speed^", "Speed#First"):
        assert refused(handle, device, f"MAIN.aBlocks[1].{name}") == ReturnCode.SYMBOL_NOT_FOUND


def test_a_property_is_no_item_of_its_type(device: PlcDevice) -> None:
    entry = DataTypeEntry.decode(device.read_write(0xF011, 0, 0xFFFF, b"FB_More"))
    assert [member.name for member in entry.members] == ["nSpeed", "sName"]


def test_property_of_a_part_of_a_part_is_that_of_its_instance(device: PlcDevice) -> None:
    for index in (0, 1):
        name = f"Outer.fbOuter.aInner[{index}].nSpeed".encode()
        device.write(0xF005, handle(device, name.decode()), bytes([index + 1, 0]))
    for index in (0, 1):
        name = f"Outer.fbOuter.aInner[{index}].Twice".encode()
        assert device.read_write(0xF004, 0, 2, name) == bytes([2 * index + 2, 0])
        assert device.read_write(0xF007, 0, 12, name)[4:8] == bytes(4)
    name = b"Outer.fbOuter.aInner[1]#Second"
    assert call(device, name.decode(), struct.pack("<h", 7)) == struct.pack("<h", 14)


def test_property_that_is_a_reference_is_not_what_it_refers_to(device: PlcDevice) -> None:
    entry = SymbolEntry.decode(device.read_write(0xF009, 0, 1000, b"MAIN.aBlocks[1].Target"))
    assert entry.type_name == "REFERENCE TO INT"


@pytest.mark.parametrize("part", ["#First", ".Twice"])
def test_static_block_has_no_instance_for_its_methods_and_properties(
    device: PlcDevice, part: str
) -> None:
    name = f"FB_Outer.fbStatic{part}"
    assert refused(handle, device, name) == ReturnCode.SERVICE_NOT_SUPPORTED
    assert handle(device, "FB_Outer.fbStatic.nSpeed")


def test_program_with_methods_or_properties_is_a_symbol(device: PlcDevice) -> None:
    assert handle(device, "Called#First")
    assert handle(device, "Monitored.Count")
    assert refused(handle, device, "Plain") == ReturnCode.SYMBOL_NOT_FOUND
