"""Symbols: each value of services and process image, by name, as tables and handles show them."""

from typing import Any

import pytest

from achse.ams import DeviceError
from achse.devices.camshaft import CamshaftDevice, ServedCamshaft
from achse.devices.camshaft.symbols import CamSymbols
from achse.devices.value_symbols import ValueSymbol
from achse.iec.symbols import decode_symbols


def symbol_of(device: CamshaftDevice, name: str) -> ValueSymbol:
    assert device.symbols is not None
    result = device.symbols.source.resolve(name)
    assert isinstance(result, ValueSymbol)
    return result


@pytest.mark.parametrize(
    ("name", "type", "place"),
    [
        ("Press.set_rate", "UDINT", (0x1000, 0x34)),
        ("press.ACTIVE", "BOOL", (0x1000, 0x2)),
        ("Press.Encoder.zero_point", "DINT", (0x1001, 0x201)),
        ("Press.Encoder.box_address", "USINT", (0x1001, 0x210)),
        ("Press.Cam128.start", "UDINT", (0x1180, 0x2)),
        ("Press.Blow.track", "UDINT", (0x1103, 0x4)),
        ("Camshaft 2.Cam1.type", "USINT", (0x2101, 0x1)),
        ("Camshaft 4.Inputs.or_mask", "UDINT", (0xF020, 0x344)),
        ("Camshaft 2.Outputs.cams", "UDINT", (0xF030, 0x140)),
    ],
)
def test_names_lead_to_the_rows(
    device: CamshaftDevice, name: str, type: str, place: tuple[int, int]
) -> None:
    symbol = symbol_of(device, name)
    assert symbol.type.name == type
    assert (symbol.index_group, symbol.index_offset) == place
    assert symbol.read() == device.read(*place, 4)
    assert device.symbols is not None
    assert device.symbols.source.type_entry(type)


def test_what_is_written_is_checked(device: CamshaftDevice) -> None:
    start = symbol_of(device, "Press.Cam1.start")
    start.write(b"\7\0\0\0")
    assert start.read() == b"\7\0\0\0"
    with pytest.raises(DeviceError):
        start.write(b"\xff\xff\0\0")
    kind = symbol_of(device, "Press.Cam1.type")
    assert kind.read_only
    with pytest.raises(DeviceError):
        kind.write(b"\1")


def test_tracks_are_bits(device: CamshaftDevice, camshafts: list[ServedCamshaft]) -> None:
    camshafts[0].controller.record.outputs = 1 << 31
    assert symbol_of(device, "Press.Tracks.31").read() == b"\1"
    assert symbol_of(device, "Press.Tracks.0").read() == b"\0"


def test_every_symbol_is_read_where_the_table_says(camshaft: Any, device: CamshaftDevice) -> None:
    """A client that has the table need not ask by name."""
    assert device.symbols is not None
    for entry in decode_symbols(device.symbols.source.symbol_table()):
        data = camshaft.read(entry.index_group, entry.index_offset, entry.size)
        assert data == symbol_of(device, entry.name).read(), entry.name


def test_the_tables(device: CamshaftDevice) -> None:
    assert device.symbols is not None
    source = device.symbols.source
    assert isinstance(source, CamSymbols)
    entries = decode_symbols(source.symbol_table())
    assert len(entries) == source.upload_info().symbol_count
    assert {entry.type_name for entry in entries} == {"BOOL", "USINT", "UDINT", "DINT"}
    assert source.resolve("Press.Cam129.start") is None
    assert source.type_table()
    assert source.type_entry("LREAL") is None
