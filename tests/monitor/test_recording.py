"""A recording knows what was answered, whatever the handles were, and what differs."""

import struct
from collections.abc import Callable
from typing import Any

from achse.ams import Command
from achse.monitor.names import rows_of
from achse.monitor.recording import Key, Recording, differences


def session(traffic: Any, spare_handles: int = 0, value: int = -16) -> Recording:
    """A client that reads, writes, watches; its handles depend on what went before."""
    for _ in range(spare_handles):
        traffic.handle("GVL.nUint")
    traffic.captures()
    handle = traffic.handle("GVL.nInt")
    traffic.plc.put(0xF005, handle, "<h", value)
    for _ in range(3):
        traffic.plc.read(0xF005, handle, 2)
    traffic.plc.subscribe(0xF005, traffic.handle("MAIN.nCounter"), 4, cycle_s=0.01)
    traffic.station.advance(0.03)
    return Recording(traffic.captures())


def test_answers_are_kept_by_name(traffic: Any) -> None:
    recording = session(traffic, value=5)
    assert recording.net_id == traffic.station.router.net_id
    plc = recording.devices[851]
    assert set(plc.handles) == {b"gvl.nint", b"main.ncounter"}
    reads = plc.answers[Key(Command.READ, 0xF005, 0, b"gvl.nint")]
    assert [(each.result, each.data) for each in reads] == [(0, struct.pack("<h", 5))] * 3
    [samples] = plc.samples.values()
    assert [int.from_bytes(data, "little") for _, data in samples] == [0, 1, 2, 3]
    assert [time for time, _ in samples] == [1_000_000, 2_000_000, 3_000_000, 4_000_000]


def test_equal_sessions_do_not_differ_whatever_their_handles(
    make_traffic: Callable[[], Any],
) -> None:
    one, two = session(make_traffic()), session(make_traffic(), spare_handles=3)
    assert one.devices[851].handles != two.devices[851].handles
    assert list(differences(one, two)) == []


def test_what_differs_is_reported(make_traffic: Callable[[], Any], refused: Any) -> None:
    first, second = make_traffic(), make_traffic()
    one = session(first)
    second.nc.read(0x4001, 0x02, 31)
    extra = second.captures()
    two = Recording([*session(second, value=7).captures, *extra])
    rows = rows_of(first.station.devices)
    assert list(differences(one, two, rows)) == [
        "+ 501 read axis_name[1]: 'X'",
        "! 851 read GVL.nInt: f0 ff → 07 00",
        "! 851 write GVL.nInt: f0 ff → 07 00",
    ]


def test_types_that_one_client_requested_serve_both_recordings_from_their_start(
    make_traffic: Callable[[], Any],
) -> None:
    first, second = make_traffic(), make_traffic()
    one = session(first)
    typed = session(second)
    second.plc.exchange(0xF009, 0, 200, b"GVL.nInt\0")
    captures = second.captures()
    rows = rows_of(first.station.devices)
    assert list(differences(one, Recording([*typed.captures, *captures]), rows)) == [
        "+ 851 ask symbol entry by name GVL.nInt: INT"
    ]
    two = Recording([*session(second, value=7).captures, *captures])
    assert "! 851 read GVL.nInt: -16 → 7" in list(differences(one, two, rows))


def test_errors_differ_from_values(make_traffic: Callable[[], Any], refused: Any) -> None:
    one, two = make_traffic(), make_traffic()
    two.station.faults.add("error", group=0x4020, port=851, code=0x705)
    one.plc.read(0x4020, 0, 2)
    with refused(0x705):
        two.plc.read(0x4020, 0, 2)
    lines = list(differences(Recording(one.captures()), Recording(two.captures())))
    assert lines == ["! 851 read 0x4020:0x0: 00 00 → error 0x705"]


def test_an_empty_capture_is_an_empty_recording() -> None:
    assert Recording([]).devices == {}
