"""Symbols of an NC by name, over the wire's services and with pyads' way of asking."""

import struct
from typing import Any

import pytest

from achse.devices.nc.axes.states import AXIS_STATES
from achse.iec.datatypes import decode_types
from achse.iec.symbols import decode_symbols
from achse.iec.typetable import TypeTable


def by_name(bench: Any, name: str, size: int) -> bytes:
    return bytes(bench.exchange(0xF004, 0, size, name.encode() + b"\0"))


@pytest.fixture
def table(bench: Any) -> dict[str, Any]:
    return {s.name: s for s in decode_symbols(bench.device.symbols.source.symbol_table())}


def test_every_row_with_a_symbol_is_one_per_axis(table: dict[str, Any]) -> None:
    for row in AXIS_STATES:
        if row.symbol:
            for axis_id, axis in ((1, "X"), (3, "C")):
                symbol = table[f"Axes.{axis}.{row.symbol}"]
                assert (symbol.index_group, symbol.index_offset) == (0x4100 + axis_id, row.offset)
    assert {"Axes.X.ControlDWord", "Axes.X.OverrideV", "Axes.C.StateDWord"} <= table.keys()
    assert table["Axes.X.SetPos"].type_name == "LREAL"
    assert table["Axes.X.CmdNo"].type_name == "UDINT"


def test_a_value_by_name_is_the_value_of_the_row(bench: Any) -> None:
    bench.start(50.0, 100.0)
    bench.run(0.3)
    for name, group, offset in (
        ("Axes.X.SetPos", 0x4101, 0x0A),
        ("axes.x.actpos", 0x4101, 0x1_0002),
        ("Axes.X.PosDiff", 0x4101, 0x2_000F),
        ("Axes.X.DriveOutput", 0x4101, 0x3_0002),
    ):
        assert by_name(bench, name, 8) == bench.read(group, offset, 8)
    assert struct.unpack("<d", by_name(bench, "Axes.X.SetPos", 8))[0] > 1.0


def test_every_entry_can_be_read_at_its_address(bench: Any, table: dict[str, Any]) -> None:
    for symbol in table.values():
        data = bench.read(symbol.index_group, symbol.index_offset, symbol.size)
        assert len(data) == symbol.size


def test_the_structures_and_their_members(bench: Any, table: dict[str, Any]) -> None:
    bench.start(50.0, 100.0)
    bench.run(0.3)
    assert table["Axes.X.ToPlc"].size == 256
    assert table["Axes.X.FromPlc"].size == 128
    whole = by_name(bench, "Axes.X.ToPlc", 256)
    assert whole == bench.read(0x4301, 0x80, 256)
    assert by_name(bench, "Axes.X.ToPlc.SetPos", 8) == whole[80:88]
    assert by_name(bench, "Axes.X.ToPlc.ActAcc", 8) == whole[232:240]
    group, offset, size = struct.unpack(
        "<III", bench.exchange(0xF007, 0, 12, b"Axes.X.ToPlc.SetPos\0")
    )
    assert bench.read(group, offset, size) == whole[80:88]


def test_what_comes_from_the_plc_can_be_written_by_name(bench: Any, refused: Any) -> None:
    handle = bench.exchange(0xF003, 0, 4, b"Axes.X.FromPlc.Override\0")
    bench.write(0xF005, struct.unpack("<I", handle)[0], struct.pack("<I", 250_000))
    assert bench.axis.velocity_override == 250_000
    assert bench.axis.control_dword == 7
    with refused(0x42CE):
        bench.write(0xF005, struct.unpack("<I", handle)[0], struct.pack("<I", 1_000_001))
    assert bench.axis.velocity_override == 250_000
    handle = bench.exchange(0xF003, 0, 4, b"Axes.X.SetPos\0")
    with refused(0x704):
        bench.write(0xF005, struct.unpack("<I", handle)[0], bytes(8))


@pytest.mark.parametrize(
    "name", ["Axes.Y.SetPos", "Axes.X.NoSuch", "Axes.X.ToPlc.NoSuch", "SetPos"]
)
def test_unknown_names(bench: Any, refused: Any, name: str) -> None:
    with refused(0x710):
        by_name(bench, name, 8)


def test_the_uploaded_types_describe_the_structures(bench: Any) -> None:
    source = bench.device.symbols.source
    types = TypeTable(decode_types(source.type_table()))
    value = types.type("NCTOPLC_AXIS_REF").decode(bench.read(0x4301, 0x80, 256))
    assert value.AxisId == 1
    assert value.OpModeDWord == bench.axis.operation_mode_and_cycle
    assert source.type_entry("plctonc_axis_ref") is not None
    assert source.type_entry("nothing") is None
    info = source.upload_info()
    assert info.symbol_count == len(decode_symbols(source.symbol_table()))


def test_the_member_addresses_end_with_their_structures(bench: Any, refused: Any) -> None:
    with refused(0x703):
        bench.read(0x0100_4301, 256, 4)
    with refused(0x704):
        bench.write(0x0100_4301, 0, bytes(4))
    bench.write(0x0100_4301, 0x1004, struct.pack("<I", 10))
    assert bench.axis.velocity_override == 10


def test_a_handle_can_be_watched(bench: Any) -> None:
    handle = struct.unpack("<I", bench.exchange(0xF003, 0, 4, b"Axes.X.ToPlc.SetPos\0"))[0]
    bench.client.subscribe(0xF005, handle, 8, cycle_s=0.002)
    bench.start(50.0, 100.0)
    positions = []
    for _ in range(100):
        bench.run(0.002)
        bench.device.notifications.tick(bench.nc.cycle_count * 2_000_000)
        positions += [struct.unpack("<d", data)[0] for _, data in bench.client.samples()]
    assert len(positions) >= 100
    assert positions == sorted(positions)
    assert positions[-1] == bench.axis.set_position > 1.0


def test_groups_of_several_axes_have_the_symbols_of_the_manual(groups: Any) -> None:
    """000, 002: SafEntries of every group, SetPathVelo and others of paths alone."""
    symbols = groups.device.symbols.source
    for name in ("SvbEntries", "SafEntries", "BlockNumber", "SetPathRemLength", "SetPathVelo"):
        assert symbols.resolve(f"Groups.3D.{name}") is not None
    velocity = symbols.resolve("groups.3d.setpathvelo")
    assert (velocity.index_group, velocity.index_offset, velocity.size) == (0x310B, 0x502, 8)
    assert velocity.read() == bytes(8)
    assert symbols.resolve("Groups.Group 12.SafEntries") is not None
    assert symbols.resolve("Groups.Group 12.SetPathVelo") is None
    names = [name for name in symbols._symbols if name.startswith(("groups.3d", "GROUPS.3D"))]
    assert len(names) == 19
