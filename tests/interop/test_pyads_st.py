"""pyads and the Structured Text of two PLCs in real time: states, values, methods, a fault."""

import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

PRESS = """\
PROGRAM MAIN
VAR
    nDivisor : DINT := 1;
    nCount : UDINT;
    nPart : DINT;
END_VAR
nCount := nCount + 1;
nPart := nPart / nDivisor;
END_PROGRAM
"""
FEEDER = """\
FUNCTION_BLOCK FB_Feeder
VAR
    nSum : DINT;
    nCycles : UDINT;
END_VAR
nCycles := nCycles + 1;
{attribute 'TcRpcEnable'}
METHOD Add : DINT
VAR_INPUT
    nWhat : DINT;
END_VAR
nSum := nSum + nWhat;
Add := nSum;
END_METHOD
END_FUNCTION_BLOCK

PROGRAM MAIN
VAR
    nCount : UDINT;
    fbFeeder : FB_Feeder;
END_VAR
nCount := nCount + 1;
fbFeeder();
END_PROGRAM
"""
STATION = """\
[[plc]]
sources = "press.st"
[[plc]]
port = 852
sources = "feeder.st"
[[axis]]
id = 1
name = "X"
"""
WHY = "exception DIVIDEBYZERO in MAIN (press.st, line 8)"
SET_POSITION, FUNCTION, CYCLIC = (0x4101, 0x0A), 0x4201, 0x4301
ENDLESS_POSITIVE = 3
EVERY_MESSAGE = (1, 65535)
VALUE_BY_HANDLE = 0xF005
EXCEPTION = 19  # ADS state


@pytest.fixture(scope="module")
def station(
    start_station: Callable[..., AbstractContextManager[Any]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Any]:
    folder = tmp_path_factory.mktemp("station")
    for name, text in (("press.st", PRESS), ("feeder.st", FEEDER), ("station.toml", STATION)):
        (folder / name).write_text(text)
    with start_station(str(folder / "station.toml")) as running:
        yield running


@pytest.fixture
def feeder(station: Any, pyads_connection: Callable[..., Any]) -> Any:
    return pyads_connection(station, 852)


def _count(plc: Any) -> int:
    return int(plc.read_by_name("MAIN.nCount", pyads.PLCTYPE_UDINT))


def test_values_come_once_a_cycle_and_stop_with_the_plc(
    feeder: Any, until: Callable[..., None]
) -> None:
    values: list[int] = []

    @feeder.notification(pyads.PLCTYPE_UDINT)
    def note(handle: int, name: str, timestamp: Any, value: int) -> None:
        values.append(value)

    attributes = pyads.NotificationAttrib(4, pyads.ADSTRANS_SERVERONCHA, 0, 10)
    handles = feeder.add_device_notification("MAIN.nCount", attributes, note)
    until(lambda: len(values) > 20)
    feeder.write_control(pyads.ADSSTATE_STOP, 0, 0, pyads.PLCTYPE_INT)
    assert feeder.read_state() == (pyads.ADSSTATE_STOP, 0)
    last = _count(feeder)
    until(lambda: values[-1] == last)
    feeder.write_control(pyads.ADSSTATE_RUN, 0, 0, pyads.PLCTYPE_INT)
    until(lambda: values[-1] > last + 20)
    feeder.del_device_notification(*handles)
    assert values == list(range(values[0], values[0] + len(values)))


def test_methods_are_called_between_cycles(feeder: Any, until: Callable[..., None]) -> None:
    before = feeder.read_by_name("MAIN.fbFeeder.nCycles", pyads.PLCTYPE_UDINT)
    handle = feeder.get_handle("MAIN.fbFeeder#Add")
    begin = feeder.read_by_name("MAIN.fbFeeder.nSum", pyads.PLCTYPE_DINT)
    for number in range(1, 101):
        total = feeder.read_write(
            VALUE_BY_HANDLE, handle, pyads.PLCTYPE_DINT, 3, pyads.PLCTYPE_DINT
        )
        assert total == begin + 3 * number
    feeder.release_handle(handle)
    until(lambda: feeder.read_by_name("MAIN.fbFeeder.nCycles", pyads.PLCTYPE_UDINT) > before + 20)
    assert feeder.read_by_name("MAIN.fbFeeder.nSum", pyads.PLCTYPE_DINT) == begin + 300


def test_a_fault_stops_its_plc_alone(
    station: Any, feeder: Any, pyads_connection: Callable[..., Any], until: Callable[..., None]
) -> None:
    press, nc = pyads_connection(station, 851), pyads_connection(station, 501)
    logger = pyads_connection(station, 100)
    reports: list[bytes] = []

    def note(notification: Any, _: Any) -> None:
        reports.append(bytes(logger.parse_notification(notification, None, True)[2]))

    handles = logger.add_device_notification(
        EVERY_MESSAGE, pyads.NotificationAttrib(255, pyads.ADSTRANS_SERVERONCHA), note
    )

    def place() -> float:
        return float(nc.read(*SET_POSITION, pyads.PLCTYPE_LREAL))

    nc.write(CYCLIC, 0x01, 0b111, pyads.PLCTYPE_UDINT)
    nc.write(CYCLIC, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)
    start = struct.pack("<IIdd", ENDLESS_POSITIVE, 0, 0.0, 10.0)
    until(lambda: nc.read(0x4101, 0x0E, pyads.PLCTYPE_LREAL) == 0.0)
    nc.write(FUNCTION, 0x20, list(start), pyads.PLCTYPE_BYTE * len(start))
    begin = place()
    until(lambda: place() > begin)
    press.write_by_name("MAIN.nDivisor", 0, pyads.PLCTYPE_DINT)
    until(lambda: press.read_state() == (EXCEPTION, 0))
    until(lambda: any(WHY.encode() in message for message in reports))
    stopped, others, where = _count(press), _count(feeder), place()
    until(lambda: _count(feeder) > others + 50)
    until(lambda: place() > where + 1.0)
    assert _count(press) == stopped
    with pytest.raises(pyads.ADSError) as refused:
        press.write_control(pyads.ADSSTATE_RUN, 0, 0, pyads.PLCTYPE_INT)
    assert refused.value.err_code == 0x712
    press.write_control(pyads.ADSSTATE_RESET, 0, 0, pyads.PLCTYPE_INT)
    press.write_control(pyads.ADSSTATE_RUN, 0, 0, pyads.PLCTYPE_INT)
    until(lambda: _count(press) > 5)
    logger.del_device_notification(*handles)
    nc.write(FUNCTION, 0x02, [], None)
