"""The NC as the PLC libraries address it: start types, ports, records, bits and bytes.

Facts of Tc2_MC2's own constants and structures, which the manuals print otherwise or not at all.
"""

import struct
from collections.abc import Iterator
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.axis import StartType, StateBit
from achse.codes.nc.structures import FROM_PLC
from achse.devices.nc import NcDevice
from achse.devices.nc.axes.structures import PLC_TO_NC, PLCTONC_AXIS_REF
from achse.iec import StructType
from achse.motion.states import TorqueStartType
from achse.router import Router
from achse.st.declared.standard import standard_libraries
from achse.station import Station
from achse.station.configuration.station_file import parse

FUNCTIONS, STATES, TO_PLC, FROM = 0x4201, 0x4101, 0x80, 0x00
PORTS = (500, 501)


@pytest.fixture
def station() -> Station:
    axes = [{"id": 1, "name": "X"}, {"id": 2, "name": "Y"}]
    station = Station(parse({"axis": axes}, "a.toml"))
    assert station.nc is not None
    for axis in (station.nc.axis(1), station.nc.axis(2)):
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(0.02)
    return station


def _axis(station: Station, number: int = 1) -> Any:
    assert station.nc is not None
    return station.nc.axis(number)


def _nc(station: Station) -> NcDevice:
    (device,) = (each for each in station.devices if isinstance(each, NcDevice))
    return device


def _start(station: Station, kind: int, position: float) -> tuple[int, int]:
    """Universal start with defaults, 0x16: number and state of the command."""
    data = struct.pack("<II5dII3d", kind, 0, position, 100.0, *[0.0] * 3, 0, 0, *[0.0] * 3)
    answer = _nc(station).read_write(FUNCTIONS, 0x16, 4, data)
    number, state = struct.unpack("<HH", answer)
    return number, state


def test_additive_counts_from_the_last_target_relative_from_here(station: Station) -> None:
    assert (StartType.ADDITIVE, StartType.ABSOLUTE_INTERNAL, StartType.MODULO_CURRENT) == (
        6,
        9,
        1029,
    )
    _start(station, 1, 100.0)
    station.advance(0.4)
    _start(station, 6, 20.0)
    station.advance(5.0)
    assert _axis(station).set_position == 120.0
    _start(station, 1, 0.0)
    station.advance(0.8)
    here = _axis(station).set_position
    _start(station, 2, 5.0)
    station.advance(5.0)
    assert _axis(station).set_position == pytest.approx(here + 5.0, abs=1e-6)
    _start(station, 9, 10.0)
    station.advance(5.0)
    assert _axis(station).set_position == 10.0
    _start(station, 1029, 350.0)
    station.advance(9.0)
    assert _axis(station).set_position == pytest.approx(-10.0)  # went to smaller ones before


@pytest.mark.parametrize("kind", [272, 273, 528, 529])
def test_jogs_are_start_types(station: Station, kind: int) -> None:
    _start(station, kind, 0.0)
    station.advance(3.0)
    assert _axis(station).set_velocity * (-1 if kind & 1 else 1) > 0.0


def test_torque_has_start_types_of_its_own(station: Station) -> None:
    assert [int(each) for each in TorqueStartType] == [12288, 12289, 12290]

    def torque(kind: int) -> bytes:
        data = struct.pack("<4I7d", kind, 0, 0, 0, 5.0, 0.0, 100.0, -100.0, 0.0, 0.0, 0.0)
        return _nc(station).read_write(FUNCTIONS, 0x2D, 4, data)

    with pytest.raises(DeviceError) as error:
        torque(12288)
    assert error.value.code == NcError.GENERATOR_INACTIVE
    for kind in (12289, 12290, 12288):
        torque(kind)
        station.advance(0.05)
    for kind in (12287, 12291, 1):
        with pytest.raises(DeviceError) as error:
            torque(kind)
        assert error.value.code == NcError.START_TYPE


def _on_both_ports() -> Iterator[tuple[int, int, int, bytes]]:
    """Motion, coupling and reset at 500, superposition at 501; each is taken at both."""
    commands = (
        (0x01, b""),
        (0x20, struct.pack("<IIdd", 1, 0, 5.0, 10.0)),
        (0x02, b""),
        (0x1A, struct.pack("<IId", 1, 0, 0.0)),
        (0x40, struct.pack("<4I4d", 1, 2, 0, 0, 1.0, 0.0, 0.0, 0.0)),
        (0x31, b""),
    )
    for port in PORTS:
        for offset, data in commands:
            yield port, FUNCTIONS, offset, data


@pytest.mark.parametrize(("port", "group", "offset", "data"), list(_on_both_ports()))
def test_commands_at_either_port(
    station: Station, port: int, group: int, offset: int, data: bytes
) -> None:
    from achse.ams import AmsAddress, Command, Frame

    answers: list[bytes] = []
    router: Router = station.router

    class Client:
        def deliver(self, frame: Frame) -> bool:
            answers.append(bytes(frame.data[:4]))
            return True

    own = router.register(40_000, Client())
    target = AmsAddress.of(router.net_id, port)
    request = struct.pack("<III", group, offset, len(data)) + data
    router.deliver(Frame(target, own, Command.WRITE, invoke_id=1, data=request))
    station.advance(0.01)
    (answer,) = answers
    code = int.from_bytes(answer, "little")
    assert code == 0 or (offset, NcError.of(code)) == (0x31, code)  # nothing is superposed


@pytest.mark.parametrize(("kind", "end"), [(1, 33.0), (2, 83.0)])
def test_the_set_position_record_of_32_bytes(station: Station, kind: int, end: float) -> None:
    """0x1F: kind, control word, the previous position, the new one, two reserved words."""
    _start(station, 1, 50.0)
    station.advance(5.0)
    record = struct.pack("<IIddII", kind, 0, 50.0, 33.0, 0, 0)
    assert len(record) == 32
    _nc(station).write(FUNCTIONS, 0x1F, record)
    station.advance(0.01)
    assert _axis(station).actual_position == pytest.approx(end, abs=1e-3)


def test_bits_15_and_18_of_the_state_double_word(station: Station) -> None:
    assert (StateBit.PHASING_ACTIVE, StateBit.DRIVE_LIMIT_ACTIVE) == (1 << 15, 1 << 18)

    def shown() -> int:
        word: int = struct.unpack("<I", _nc(station).read(0x4301, 0x80, 256)[:4])[0]
        return word & (StateBit.PHASING_ACTIVE | StateBit.DRIVE_LIMIT_ACTIVE)

    assert shown() == 0
    couple = struct.pack("<4I4d", 1, 2, 0, 0, 1.0, 0.0, 0.0, 0.0)
    _nc(station).write(FUNCTIONS, 0x40, couple)
    phasing = struct.pack("<III4x5d36xId", 1, 0, 2, 50.0, 10.0, 0.0, 0.0, 0.0, 0, 0.0)
    _nc(station).write(FUNCTIONS, 0x34, phasing)
    station.advance(0.1)
    assert shown() == StateBit.PHASING_ACTIVE
    station.advance(20.0)
    _nc(station).write(FUNCTIONS, 0x41, b"")
    assert shown() == 0
    torque = struct.pack("<4I7d", 12289, 0, 0, 0, 200.0, 0.0, 5.0, -5.0, 0.0, 0.0, 0.0)
    _nc(station).read_write(FUNCTIONS, 0x2D, 4, torque)
    station.advance(1.0)
    assert shown() == StateBit.DRIVE_LIMIT_ACTIVE


def test_bytes_104_to_119_from_the_plc() -> None:
    type: StructType[Any] = PLCTONC_AXIS_REF.__iec__
    places = {field.name: (field.offset, field.type.size) for field in type.fields}
    assert places["MapState"] == (104, 1)
    assert places["PlcCycleControl"] == (105, 1)
    assert places["PlcCycleCount"] == (106, 1)
    assert places["ExtTorque"] == (112, 8)
    assert (type.size, PLC_TO_NC.size) == (128, 128)
    data = bytearray(128)
    struct.pack_into("<d", data, 112, 12.5)
    assert PLC_TO_NC.decode(bytes(data))["external_set_torque"] == 12.5
    assert {each.name for each in FROM_PLC} >= set(places)


def test_numbers_of_the_libraries_own_choices() -> None:
    """Modes of homing and buffering, whose numbers the manual does not print."""
    units = {
        unit.name: unit
        for parsed in standard_libraries()
        if parsed.source.path.startswith("tc2_mc2/")
        for unit in parsed.units
    }

    def numbers(name: str) -> list[int]:
        unit: Any = units[name]
        return [int(value.value.text) for value in unit.type.values]

    assert numbers("MC_HomingMode") == [0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert numbers("MC_BufferMode") == [0, 1, 18, 19, 20, 21]
