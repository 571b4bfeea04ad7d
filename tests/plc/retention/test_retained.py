"""Images of retained variables: their bytes and no others, and values by name without the PLC."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc.memory import Area
from achse.plc.retention.retained import RetainedLayout, retained_parts
from tests.plc.code.conftest import Ran

TEXT = """
TYPE ST_Flags : STRUCT a : BIT; b : BIT; n : BYTE; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Pump
VAR n1 : BYTE; END_VAR
VAR PERSISTENT nStarts : UINT; bRuns : BIT; END_VAR
VAR bOther : BIT; n2 : LINT; END_VAR
VAR_STAT PERSISTENT nAll : DINT; END_VAR
END_FUNCTION_BLOCK
VAR_GLOBAL RETAIN rFirst : LREAL; bSecond : BOOL; nThird : LINT; END_VAR
VAR_GLOBAL PERSISTENT sName : STRING(5); stFlags : ST_Flags; END_VAR
PROGRAM MAIN
VAR n : DINT; END_VAR
VAR PERSISTENT p : POINTER TO DINT; fb : FB_Pump; END_VAR
VAR a : ARRAY [0..2] OF FB_Pump; END_VAR
VAR RETAIN aLast : ARRAY [0..3] OF INT; END_VAR
END_PROGRAM
"""


@pytest.fixture(scope="module")
def ran() -> Ran:
    return Ran(TEXT, has_twin=False).cycle()


@pytest.fixture(scope="module")
def layout(ran: Ran) -> RetainedLayout:
    return RetainedLayout.of(ran.plc)


def test_each_retained_part_is_in_the_layout_once(layout: RetainedLayout) -> None:
    expected = [
        *("FB_Pump.nAll", "GVL.bSecond", "GVL.nThird", "GVL.rFirst", "GVL.sName", "GVL.stFlags"),
        *(f"MAIN.a[{n}].{name}" for n in range(3) for name in ("bRuns", "nStarts")),
        *("MAIN.aLast", "MAIN.fb", "MAIN.p"),
    ]
    assert sorted(row.name for row in layout.rows) == sorted(expected)


@given(st.data())
def test_values_of_an_image_are_those_of_the_memory(
    ran: Ran, layout: RetainedLayout, data: st.DataObject
) -> None:
    """Whatever the bytes are; also with the layout as a file keeps it."""
    expected = {}
    for part in retained_parts(ran.plc):
        region, (begin, end) = ran.plc.memory[part.area], part.span
        content = data.draw(st.binary(min_size=end - begin, max_size=end - begin))
        if part.name == "MAIN.p":
            content = bytes(8)
        region.write(begin, content)
    for part in retained_parts(ran.plc):
        region, (begin, end) = ran.plc.memory[part.area], part.span
        expected[part.name] = (
            region.read(begin, end - begin)
            if part.bit is None
            else region.read_bits(8 * part.offset + part.bit, 1)
        )
    image = layout.image(ran.plc.memory)
    values = layout.variables(image)
    assert {name: value.data for name, value in values.items()} == expected
    restored = RetainedLayout.parsed(json.loads(json.dumps(layout.document())))
    assert restored.variables(image) == values


@given(st.integers(370, 520), st.integers(1, 255))
def test_image_changes_with_retained_bytes_only(
    ran: Ran, layout: RetainedLayout, offset: int, change: int
) -> None:
    """Each byte of an image is one of a retained part: nothing else leads to a write."""
    region = ran.plc.memory[Area.DATA]
    spans = [part.span for part in retained_parts(ran.plc) if part.area is Area.DATA]
    before = layout.image(ran.plc.memory)
    (old,) = region.read(offset, 1)
    region.write(offset, bytes([old ^ change]))
    is_retained = any(begin <= offset < end for begin, end in spans)
    assert (layout.image(ran.plc.memory) != before) == is_retained
    region.write(offset, bytes([old]))


def test_pointers_of_an_image_are_named(ran: Ran, layout: RetainedLayout) -> None:
    memory, places = ran.plc.memory, {one.name: one for one in ran.plc.variables}
    pointer, n, last = (places[f"MAIN.{name}"] for name in ("p", "n", "aLast"))
    for address, leads in (
        (memory.address(n.area, n.offset), [("MAIN.n", 0)]),
        (memory.address(last.area, last.offset) + 7, [("MAIN.aLast", 7)]),
        (memory.address(Area.FLAG, 5), [("%M", 5)]),
        (memory.address(Area.HEAP, 0), []),
        (0, []),
        (1 << 40, []),
    ):
        memory[pointer.area].write(pointer.offset, address.to_bytes(8, "little"))
        value = layout.variables(layout.image(memory))["MAIN.p"]
        assert value.data == bytes(8)
        assert [(lead.target, lead.offset) for lead in value.leads] == leads


@pytest.mark.parametrize(
    "change",
    [
        {"size": 3},
        {"size": None},
        {"rows": [["MAIN.n", "", -1, 4, None, []]]},
        {"rows": [["MAIN.b", "", 0, 0, 1, []]]},
        {"rows": [["MAIN.n", "", 0, 4]]},
        {"targets": [["x", 4, "MAIN.n", ""]]},
    ],
)
def test_layout_that_cannot_be_is_refused(layout: RetainedLayout, change: dict[str, Any]) -> None:
    with pytest.raises((ValueError, TypeError)):
        RetainedLayout.parsed(layout.document() | change)
