"""What built-in routines see of their PLC: memory, heap, records and time."""

import pytest

from achse.iec.structs import StructType
from achse.plc.bodies import Bodies
from achse.plc.code.faults import PlcFault
from achse.plc.memory import Area
from achse.plc.routines.builtin_memory import BuiltinMemory
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

TEXT = """
FUNCTION_BLOCK FB_Tank VAR nLevel : DINT := 5; END_VAR END_FUNCTION_BLOCK
PROGRAM MAIN VAR tank : FB_Tank; n : INT; END_VAR n := n + 1; END_PROGRAM
"""
EPOCH_NS = 1_700_000_000 * 10**9


@pytest.fixture
def plc() -> PlcRuntime:
    declared = declare([parse(Source(TEXT, "memory.st"), name="GVL")])
    bodies = Bodies(check(declared), epoch=lambda: EPOCH_NS)
    task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
    return PlcRuntime([task], declared.units, bodies=bodies)


def context_of(plc: PlcRuntime) -> BuiltinMemory:
    assert plc.bodies is not None
    return plc.bodies.context


def address_of_tank(plc: PlcRuntime) -> int:
    main = next(each for each in plc.variables if each.name == "MAIN.tank")
    return plc.memory.address(main.area, main.offset)


def test_bytes_are_read_and_written_where_memory_is(plc: PlcRuntime) -> None:
    context, tank = context_of(plc), plc.instance("MAIN")["tank"]
    address = plc.memory.address_of(tank.__iec_buffer__, tank.__iec_offset__)
    assert address == address_of_tank(plc)
    level = next(each.offset for each in type(tank).__iec__.fields if each.name == "nLevel")
    context.store_bytes(address + level, (77).to_bytes(4, "little"))
    assert tank["nLevel"] == 77
    assert context.load_bytes(address + level, 4) == (77).to_bytes(4, "little")
    with pytest.raises(PlcFault):
        context.load_bytes(1, 4)


def test_area_of_bytes_ends_with_the_memory_in_use(plc: PlcRuntime) -> None:
    context, address = context_of(plc), address_of_tank(plc)
    assert context.area_of(address, 4) is Area.DATA
    assert context.area_of(address, 1 << 40) is None
    assert context.area_of(1, 1) is None


def test_made_bytes_are_on_the_heap_until_they_are_freed(plc: PlcRuntime) -> None:
    context = context_of(plc)
    address = context.make_bytes(b"abcd")
    assert context.load_bytes(address, 4) == b"abcd"
    assert context.area_of(address, 4) is Area.HEAP
    context.free_bytes(address)
    context.free_bytes(address)
    context.free_bytes(0)
    assert context.area_of(address, 4) is None


def test_record_at_an_address_stays_the_same_object_until_memory_moves(plc: PlcRuntime) -> None:
    context, address = context_of(plc), address_of_tank(plc)
    type = next(each.variable.type for each in plc.variables if each.name == "MAIN.tank")
    assert isinstance(type, StructType)
    record = context.record_at(address, type)
    assert record["nLevel"] == 5
    assert context.record_at(address, type) is record
    context.forget()
    assert context.record_at(address, type) is not record
    with pytest.raises(IndexError, match="no memory at address 16#1"):
        context.record_at(1, type)


def test_time_is_that_of_the_cycle_and_of_1970(plc: PlcRuntime) -> None:
    plc.run_due(30_000_000)
    context = context_of(plc)
    assert context.unix_ns - context.time_ns == EPOCH_NS
    assert context.task_number == 1
