"""Every block and function as public pages print it, and the cyclic structures byte by byte.

Table: `tests/data/nci_blocks.tsv` (tf5100, tcnci, tf5060).
"""

import struct
from pathlib import Path
from typing import Any

import pytest

from achse.st.syntax.units import Function, FunctionBlock
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.tc2_nci.conftest import units

TABLE = Path(__file__).parents[2] / "data" / "nci_blocks.tsv"
ROWS = [line.split("\t") for line in TABLE.read_text(encoding="utf-8").splitlines()[1:]]
NAMES = sorted({row[0] for row in ROWS})

SECTIONS = {"in": "VAR_INPUT", "inout": "VAR_IN_OUT", "out": "VAR_OUTPUT"}


def _type(spec: Any) -> str:
    if (target := getattr(spec, "target", None)) is not None:
        return f"POINTER TO {_type(target)}"
    if (length := getattr(spec, "length", None)) is not None:
        return f"{spec.family}({length.text})"
    if (ranges := getattr(spec, "dimensions", None)) is not None:
        return f"ARRAY[{ranges[0].low.text}..{ranges[0].high.text}] OF {_type(spec.element)}"
    return str(getattr(spec, "name", None) or spec.family)


@pytest.mark.parametrize("name", NAMES)
def test_a_block_or_function_as_printed(name: str) -> None:
    unit: Any = units()[name]
    rows = [row[1:] for row in ROWS if row[0] == name]
    assert isinstance(unit, FunctionBlock if rows[0][0] == "FB" else Function)
    for direction, section in SECTIONS.items():
        here = [
            [each.name, _type(variable.type)]
            for block in unit.blocks
            if block.section == section
            for variable in block.variables
            for each in variable.names
        ]
        assert here == [row[2:] for row in rows if row[1] == direction]
    for row in rows:
        if row[1] == "return":
            assert _type(getattr(unit, "returns")) == row[3]  # noqa: B009


def test_nothing_else_is_public() -> None:
    public = {
        name
        for name, unit in units().items()
        if isinstance(unit, Function | FunctionBlock) and not name.startswith("_")
    }
    assert public == set(NAMES)


def test_all_with_all_their_pins_as_public_examples_call_them(tmp_path: Path) -> None:
    """A variable for each pin, inputs by `:=`, outputs by `=>`."""
    declared, calls = [], []
    for name in NAMES:
        pins = []
        for _, _, direction, pin, type in (row for row in ROWS if row[0] == name):
            if direction == "return":
                declared.append(f"{name}_ret : {type};")
                continue
            declared.append(f"{name}_{pin} : {type};")
            pins.append(f"{pin} {'=>' if direction == 'out' else ':='} {name}_{pin}")
        called = f"{name}_ret := {name}"
        if isinstance(units()[name], FunctionBlock):
            declared.append(f"fb{name} : {name};")
            called = f"fb{name}"
        calls.append(f"{called}({', '.join(pins)});")
    text = "PROGRAM MAIN VAR {} END_VAR {} END_PROGRAM"
    (tmp_path / "a.st").write_text(text.format("\n".join(declared), "\n".join(calls)))
    document = {"plc": [{"sources": "a.st", "code": "plain"}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(0.05)
    assert station.plcs[851].failure == ""


def _field(nci: Any, format: str, offset: int, path: str) -> Any:
    """A value at a byte of the structure that the channel writes, as the program names it."""
    data = bytearray(160)
    struct.pack_into(format, data, offset, 1)
    place = next(each for each in nci.plc.variables if each.name == "MAIN.fromNci")
    nci.plc.memory[place.area].write(place.offset, bytes(data))
    value = nci.main["fromNci"]
    for step in path.split("."):
        value = value[int(step) if step.isdecimal() else step]
    return value


TO_PLC = (
    *(("<I", 0, "BlockNo"), ("<I", 4, "FastMFuncMask.1"), ("<I", 20, "FastMFuncMask.5")),
    *(("<H", 24, "HskMFuncNo"), ("<H", 26, "HskMFuncReq"), ("<I", 28, "HFuncValue")),
    *(("<H", 32, "SpindleRpm"), ("<H", 34, "Tool"), ("<I", 40, "IntParams.0")),
    *(("<I", 52, "IntParams.3"), ("<I", 96, "LoadedProg"), ("<H", 100, "ItpMode")),
    *(("<H", 102, "ItpState"), ("<I", 104, "ErrorCode"), ("<H", 108, "ChnId")),
    *(("<H", 110, "GrpId"), ("<H", 112, "ItfVersion"), ("<I", 116, "ChnOperationState")),
    *(("<B", 120, "McsAxisIDs.0"), ("<B", 135, "AcsAxisIDs.7")),
    ("<I", 36, "ChnState.bIsInterpolationChannel"),
)


def test_the_structure_to_the_plc(nci: Any) -> None:
    for format, offset, path in TO_PLC:
        assert _field(nci, format, offset, path) == 1, path
    for offset, path in ((56, "DoubleParams.0"), (80, "DoubleParams.3"), (88, "PathVelo")):
        assert _field(nci, "<d", offset, path) == 1.0, path
