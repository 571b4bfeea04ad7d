"""pyads reads, writes and subscribes to the PLC of the demo station."""

import subprocess
import sys
import textwrap
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

EXTREMES = {
    "GVL.bBool": ("BOOL", True, False),
    "GVL.nByte": ("BYTE", 0xFF, 0),
    "GVL.nWord": ("WORD", 0xFFFF, 0),
    "GVL.nDword": ("DWORD", 0xFFFF_FFFF, 0),
    "GVL.nSint": ("SINT", -128, 127),
    "GVL.nInt": ("INT", -32768, 32767),
    "GVL.nDint": ("DINT", -(2**31), 2**31 - 1),
    "GVL.nLint": ("LINT", -(2**63), 2**63 - 1),
    "GVL.nUsint": ("USINT", 0xFF, 0),
    "GVL.nUint": ("UINT", 0xFFFF, 0),
    "GVL.nUdint": ("UDINT", 0xFFFF_FFFF, 0),
    "GVL.nUlint": ("ULINT", 2**64 - 1, 0),
    "GVL.fReal": ("REAL", -1.5, 2.0**100),
    "GVL.fLreal": ("LREAL", -1.5, 1e300),
    "GVL.tTime": ("TIME", 0xFFFF_FFFF, 0),
    "GVL.dDate": ("DATE", 1_767_225_600, 0),
    "GVL.tTod": ("TOD", 86_399_999, 0),
    "GVL.dtDt": ("DT", 1_767_225_601, 0),
}
"""Variables of each elementary type that pyads knows: type, and two values."""

POINT = (
    ("fX", pyads.PLCTYPE_LREAL, 1),
    ("fY", pyads.PLCTYPE_LREAL, 1),
    ("sName", pyads.PLCTYPE_STRING, 1, 20),
    ("bValid", pyads.PLCTYPE_BOOL, 1),
    ("tail", pyads.PLCTYPE_BYTE, 2),
)
"""The demo's ST_Point; pyads wants alignment gaps spelled out."""


def test_device_info_and_state(plc: Any) -> None:
    name, version = plc.read_device_info()
    assert (name, version.version, version.revision) == ("Plc30 App", 3, 1)
    assert plc.read_state() == (pyads.ADSSTATE_RUN, 0)


@pytest.mark.parametrize("name", EXTREMES)
def test_a_variable_of_each_type_keeps_what_was_written(plc: Any, name: str) -> None:
    plc_type, *values = EXTREMES[name]
    kind = getattr(pyads, f"PLCTYPE_{plc_type}")
    for value in values:
        plc.write_by_name(name, value, kind)
        assert plc.read_by_name(name, kind) == value


def test_the_type_of_a_variable_is_known_to_the_target(plc: Any) -> None:
    plc.write_by_name("GVL.fLreal", 0.25)
    assert plc.read_by_name("GVL.fLreal") == 0.25
    plc.write_by_name("gvl.nint", -7)
    assert plc.read_by_name("GVL.NINT") == -7


@pytest.mark.parametrize("text", ["", "Vorschub", "x" * 79])
def test_strings(plc: Any, text: str) -> None:
    plc.write_by_name("GVL.sString", text, pyads.PLCTYPE_STRING)
    assert plc.read_by_name("GVL.sString", pyads.PLCTYPE_STRING) == text
    plc.write_by_name("GVL.wsString", text + "µ\0", pyads.PLCTYPE_WSTRING)  # pyads adds no NUL
    assert plc.read_by_name("GVL.wsString", pyads.PLCTYPE_WSTRING) == text + "µ"


def test_a_string_that_is_too_long_is_refused(plc: Any) -> None:
    with pytest.raises(pyads.ADSError) as refusal:
        plc.write_by_name("GVL.sString", "x" * 81, pyads.PLCTYPE_STRING)
    assert refusal.value.err_code == 0x705


def test_arrays(plc: Any) -> None:
    numbers = list(range(-5, 5))
    plc.write_by_name("GVL.aInt", numbers, pyads.PLCTYPE_INT * 10)
    assert plc.read_by_name("GVL.aInt", pyads.PLCTYPE_INT * 10) == numbers
    assert plc.read_by_name("GVL.aInt[9]", pyads.PLCTYPE_INT) == 4
    plc.write_by_name("GVL.aInt[3]", 77, pyads.PLCTYPE_INT)
    assert plc.read_by_name("GVL.aInt") == [*numbers[:3], 77, *numbers[4:]]


def test_structures(plc: Any) -> None:
    point = {"fX": 1.25, "fY": -2.5, "sName": "corner", "bValid": True, "tail": [0, 0]}
    plc.write_structure_by_name("GVL.stPoint", point, POINT)
    assert plc.read_structure_by_name("GVL.stPoint", POINT) == point
    assert plc.read_by_name("GVL.stPoint.fY", pyads.PLCTYPE_LREAL) == -2.5
    points = [point | {"fX": float(number)} for number in range(3)]
    plc.write_structure_by_name("GVL.aPoints", points, POINT, array_size=3)
    assert plc.read_structure_by_name("GVL.aPoints", POINT, array_size=3) == points
    assert plc.read_by_name("GVL.aPoints[3].fX", pyads.PLCTYPE_LREAL) == 2.0


def test_lists_are_read_and_written_at_once(plc: Any) -> None:
    values = {f"GVL.aInt[{index}]": index * index for index in range(10)} | {"GVL.fReal": 0.5}
    assert set(plc.write_list_by_name(values).values()) == {"no error"}
    assert plc.read_list_by_name(list(values)) == values


def test_an_unknown_name_is_refused(plc: Any) -> None:
    with pytest.raises(pyads.ADSError) as refusal:
        plc.read_by_name("GVL.nowhere", pyads.PLCTYPE_INT)
    assert refusal.value.err_code == 0x710


def test_all_symbols_can_be_listed_and_read(plc: Any) -> None:
    symbols = {symbol.name: symbol for symbol in plc.get_all_symbols()}
    assert {*EXTREMES, "MAIN.nCounter"} <= symbols.keys()
    assert symbols["MAIN.nCounter"].symbol_type == "UDINT"
    for name, (plc_type, *_) in EXTREMES.items():
        assert symbols[name].symbol_type == plc_type
        assert symbols[name].read() == plc.read_by_name(name, symbols[name].plc_type)


def test_a_symbol_reads_and_writes(plc: Any) -> None:
    symbol = plc.get_symbol("GVL.nDint")
    symbol.write(123_456)
    assert symbol.read() == 123_456
    array = plc.get_symbol("GVL.aInt")
    array.write(list(range(10)))
    assert array.read() == list(range(10))


def test_a_notification_comes_at_once_and_at_each_change(
    plc: Any, until: Callable[..., None]
) -> None:
    values: list[int] = []

    @plc.notification(pyads.PLCTYPE_DINT)
    def note(handle: int, name: str, timestamp: Any, value: int) -> None:
        values.append(value)

    plc.write_by_name("GVL.nDint", 1, pyads.PLCTYPE_DINT)
    handles = plc.add_device_notification("GVL.nDint", pyads.NotificationAttrib(4), note)
    until(lambda: values == [1])
    for value in (2, 3):
        plc.write_by_name("GVL.nDint", value, pyads.PLCTYPE_DINT)
        until(lambda: values[-1] == value)  # noqa: B023
    plc.del_device_notification(*handles)
    plc.write_by_name("GVL.nDint", 4, pyads.PLCTYPE_DINT)
    # samples come in order: what was still sent of the first is here before this one
    last: list[int] = []

    @plc.notification(pyads.PLCTYPE_DINT)
    def note_last(handle: int, name: str, timestamp: Any, value: int) -> None:
        last.append(value)

    handles = plc.add_device_notification("GVL.nDint", pyads.NotificationAttrib(4), note_last)
    until(lambda: last == [4])
    plc.del_device_notification(*handles)
    assert values == [1, 2, 3]


def test_a_cyclic_notification_keeps_its_cycle(plc: Any, until: Callable[..., None]) -> None:
    samples: list[tuple[int, int]] = []

    @plc.notification(pyads.PLCTYPE_UDINT, timestamp_as_filetime=True)
    def note(handle: int, name: str, filetime: int, value: int) -> None:
        samples.append((filetime, value))

    cycle_ms = 50
    attributes = pyads.NotificationAttrib(
        4, pyads.ADSTRANS_SERVERCYCLE, max_delay=0, cycle_time=cycle_ms
    )
    handles = plc.add_device_notification("MAIN.nCounter", attributes, note)
    until(lambda: len(samples) > 10)
    plc.del_device_notification(*handles)
    in_cycle = samples[1:]  # the first comes at once
    assert {b[0] - a[0] for a, b in pairwise(in_cycle)} == {cycle_ms * 10_000}
    counts = {b[1] - a[1] for a, b in pairwise(in_cycle)}
    assert counts == {5}, "the task counts every 10 ms"


def test_a_notification_reaches_another_process(
    station: Any, plc: Any, until: Callable[..., None]
) -> None:
    """Both processes have the same AMS address; each gets its own notifications.

    The library of pyads drops a sample that comes before it has noted the handle, which the first
    one may on a busy machine.
    """
    subscriber = textwrap.dedent(f"""\
        import pyads, threading
        seen = threading.Event()
        with pyads.Connection("{station.net_id}", 851, "{station.host}") as plc:
            @plc.notification(pyads.PLCTYPE_LINT)
            def note(handle, name, timestamp, value):
                print(f"{{value}}\\n", end="", flush=True)
                if value == 42:
                    seen.set()
            handles = plc.add_device_notification("GVL.nLint", pyads.NotificationAttrib(8), note)
            print("subscribed\\n", end="", flush=True)
            seen.wait()
            plc.del_device_notification(*handles)
        """)
    own: list[int] = []

    @plc.notification(pyads.PLCTYPE_LINT)
    def note(handle: int, name: str, timestamp: Any, value: int) -> None:
        own.append(value)

    plc.write_by_name("GVL.nLint", 1, pyads.PLCTYPE_LINT)
    handles = plc.add_device_notification("GVL.nLint", pyads.NotificationAttrib(8), note)
    with subprocess.Popen(
        [sys.executable, "-c", subscriber], stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        line = other.stdout.readline()
        assert (other.stdout.readline() if line == "1\n" else line) == "subscribed\n"
        plc.write_by_name("GVL.nLint", 42, pyads.PLCTYPE_LINT)
        assert other.stdout.read().removeprefix("1\n") == "42\n"
        assert other.wait() == 0
    until(lambda: own[-1:] == [42])
    plc.del_device_notification(*handles)
    assert own in ([1, 42], [42])


def test_the_plc_stops_and_runs_on_command(
    plc: Any, until: Callable[..., None], pass_station_time: Callable[[float], None]
) -> None:
    def count() -> int:
        return int(plc.read_by_name("MAIN.nCounter", pyads.PLCTYPE_UDINT))

    plc.write_control(pyads.ADSSTATE_STOP, 0, 0, pyads.PLCTYPE_INT)
    assert plc.read_state() == (pyads.ADSSTATE_STOP, 0)
    before = count()
    pass_station_time(0.05)
    assert count() == before
    plc.write_control(pyads.ADSSTATE_RUN, 0, 0, pyads.PLCTYPE_INT)
    assert plc.read_state() == (pyads.ADSSTATE_RUN, 0)
    until(lambda: count() > before)


def test_an_unregistered_port_is_reported(
    station: Any, pyads_connection: Callable[..., Any]
) -> None:
    with pytest.raises(pyads.ADSError) as refusal:
        pyads_connection(station, 1000).read_state()
    assert refusal.value.err_code == 6
