"""Symbols through pointers: PlcSymbols, memory and types of a PLC together."""
# ruff: noqa: N815 (IEC names)

import pytest

from achse.ams import DeviceError
from achse.devices.plc import PlcDevice
from achse.devices.plc.symbols import PlcSymbols
from achse.iec import ARRAY, INT, GlobalVariables, Struct, pointer_to, var
from achse.iec.symbols import SymbolEntry, SymbolFlag, UploadFlag
from achse.plc import Area, PlcRuntime, Task
from tests.devices.plc.test_symbols import Keeping, ST_Node, _address, symbol_named


@pytest.mark.parametrize(
    ("name", "is_constant", "is_bit"),
    [
        ("C.aFixed[1]", True, False),
        ("C.nFixed.3", True, True),
        ("C.aFree[1]", False, False),
        ("C.nFree.3", False, True),
        ("C.pFixed^", False, False),
        ("C.pFree^", False, False),
        ("C.pFree^.9", False, True),
    ],
)
def test_part_of_a_constant_is_read_only_and_the_target_of_a_pointer_is_not(
    name: str, is_constant: bool, is_bit: bool
) -> None:
    class Constants(GlobalVariables, name="C"):
        aFixed = var(ARRAY(INT, (0, 1)), constant=True)
        nFixed = var(INT, constant=True)
        pFixed = var(pointer_to(INT), constant=True)
        aFree = var(ARRAY(INT, (0, 1)))
        nFree = var(INT)
        pFree = var(pointer_to(INT))

    plc = PlcRuntime([Task()], [Constants])
    gvl = plc.unit(Constants)
    gvl.pFree = _address(plc, "C.nFree")
    placed = next(each for each in plc.variables if each.name == "C.pFixed")
    target = _address(plc, "C.nFree").to_bytes(8, "little")
    plc.memory[placed.area].write(placed.offset, target)
    symbol = symbol_named(PlcSymbols(plc), name)
    flags = SymbolEntry.decode(symbol.entry()).flags
    assert symbol.read_only is is_constant
    assert bool(flags & SymbolFlag.READ_ONLY) is is_constant
    assert bool(flags & SymbolFlag.BIT_VALUE) is is_bit


class ST_Way(Struct):  # noqa: N801
    nBefore = var(INT)
    pNode = var(pointer_to(ST_Node))


class Ways(GlobalVariables, name="W"):
    stNode = var(ST_Node, {"nValue": 5, "aMore": [1, 2, 3]})
    aWays = var(ARRAY(ST_Way, (0, 1)))
    pNode = var(pointer_to(ST_Node))


def test_pointer_within_a_variable_is_followed() -> None:
    plc = PlcRuntime([Task()], [Ways])
    device = PlcDevice(plc, clock=lambda: 0)
    plc.unit(Ways).aWays[1].pNode = _address(plc, "W.stNode")
    assert device.read_write(0xF004, 0, 2, b"W.aWays[1].pNode^.aMore[2]") == b"\2\0"


@pytest.mark.parametrize(("behind", "is_within"), [(8, True), (7, False), (1, False)])
@pytest.mark.parametrize("part", ["", ".aMore[3]"])
def test_target_of_a_pointer_ends_within_its_area(behind: int, is_within: bool, part: str) -> None:
    plc = PlcRuntime([Task()], [Ways])
    symbols = PlcSymbols(plc)
    flags = plc.memory[Area.FLAG]
    plc.unit(Ways).pNode = plc.memory.address(Area.FLAG, len(flags) - behind)
    symbol = symbol_named(symbols, f"W.pNode^{part}")
    if is_within:
        assert symbol.read() == bytes(symbol.size)
    else:
        with pytest.raises(DeviceError, match="0x722"):
            symbol.read()


@pytest.mark.parametrize("pointer_size", [4, 8])
def test_upload_info_has_the_size_of_pointers(pointer_size: int) -> None:
    info = PlcSymbols(PlcRuntime([Task()], [Keeping], pointer_size=pointer_size)).upload_info()
    expected = UploadFlag.BASE_TYPES | (UploadFlag.PLATFORM_64_BIT if pointer_size == 8 else 0)
    assert info.flags == expected
