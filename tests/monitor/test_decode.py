"""Captures become exchanges: with names, values, errors and durations."""

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.monitor.decode import Decoder, Exchange
from achse.monitor.names import Names, rows_of
from achse.router.tap import Captured


@pytest.fixture
def decoder(traffic: Any) -> Decoder:
    return Decoder(Names(rows_of(traffic.station.devices)))


def seen(decoder: Decoder, traffic: Any) -> list[Exchange]:
    return [exchange for each in traffic.captures() for exchange in decoder.see(each)]


def texts(decoder: Decoder, traffic: Any) -> list[str]:
    return [item.text for exchange in seen(decoder, traffic) for item in exchange.items]


def test_a_symbol_is_named_by_its_handle(decoder: Decoder, traffic: Any) -> None:
    traffic.plc.exchange(0xF009, 0, 200, b"GVL.nInt\0")
    handle = traffic.handle("GVL.nInt")
    traffic.plc.read(0xF005, handle, 2)
    traffic.plc.put(0xF005, handle, "<h", 9)
    traffic.plc.put(0xF006, 0, "<I", handle)
    assert texts(decoder, traffic) == [
        "ask symbol entry by name GVL.nInt = INT",
        f"ask symbol handle by name GVL.nInt = handle 0x{handle:X}",
        "read GVL.nInt = -16",
        "write GVL.nInt = 9",
        "release handle of GVL.nInt",
    ]


def test_a_service_is_named_by_its_row_and_object(decoder: Decoder, traffic: Any) -> None:
    traffic.nc.read(0x4002, 0x02, 31)
    traffic.nc.put(0x4301, 0x21, "<I", 500_000)
    traffic.nc.read(0x4301, 0x21, 4)
    name, write, read = texts(decoder, traffic)
    assert name == "read axis_name[2] = 'Y'"
    assert write.endswith("= 500000")
    assert read.removeprefix("read") == write.removeprefix("write")


def test_duration_peer_and_error(decoder: Decoder, traffic: Any, refused: Any) -> None:
    with refused(0x710):
        traffic.handle("GVL.nowhere")
    [exchange] = seen(decoder, traffic)
    assert exchange.duration_ns == 1_000_000
    assert exchange.error == 0x710
    assert exchange.peer == str(traffic.plc.address)
    assert "✗ 0x710 SYMBOL_NOT_FOUND" in exchange.items[0].text
    assert exchange.as_json()["items"][0]["name"] == "symbol handle by name GVL.nowhere"


def test_a_sum_shows_its_parts(decoder: Decoder, traffic: Any) -> None:
    handle = traffic.handle("GVL.nInt")
    parts = struct.pack("<6I", 0xF005, handle, 2, 0x7777, 0, 4)
    traffic.plc.exchange(0xF080, 2, 14, parts)
    _, exchange = seen(decoder, traffic)
    assert [item.text for item in exchange.items] == [
        "read GVL.nInt = f0 ff",
        "read 0x7777:0x0 ✗ 0x702 INVALID_GROUP: Index group not valid.",
    ]
    assert exchange.error == 0x702


def test_an_upload_gives_values_their_types_by_handle_by_name_by_address_and_in_sums(
    decoder: Decoder, traffic: Any
) -> None:
    info = struct.unpack("<16I", traffic.plc.read(0xF00F, 0, 64))
    traffic.plc.read(0xF00B, 0, info[1])
    traffic.plc.read(0xF00E, 0, info[3])
    place = struct.unpack("<III", traffic.plc.exchange(0xF007, 0, 12, b"GVL.stPoint\0"))
    nint = struct.unpack("<III", traffic.plc.exchange(0xF007, 0, 12, b"GVL.nInt\0"))
    seen(decoder, traffic)
    handle = traffic.handle("GVL.stPoint.fX")
    traffic.plc.put(0xF005, handle, "<d", 2.5)
    traffic.plc.exchange(0xF004, 0, place[2], b"gvl.stpoint\0")
    traffic.plc.read(*nint)
    traffic.plc.read(place[0], place[1], 8)
    traffic.plc.read(*place)
    traffic.plc.exchange(0xF080, 2, 18, struct.pack("<6I", *nint, 0xF005, handle, 8))
    point = "(fX := 2.5, fY := 2.0, sName := 'home', bValid := TRUE)"
    assert texts(decoder, traffic) == [
        f"ask symbol handle by name GVL.stPoint.fX = handle 0x{handle:X}",
        "write GVL.stPoint.fX = 2.5",
        f"ask symbol value by name gvl.stpoint = {point}",
        "read GVL.nInt = -16",
        "read GVL.stPoint.fX = 2.5",
        f"read GVL.stPoint = {point}",
        "read GVL.nInt = -16",
        "read GVL.stPoint.fX = 2.5",
    ]


def test_samples_of_addresses_have_types_too(decoder: Decoder, traffic: Any) -> None:
    info = struct.unpack("<16I", traffic.plc.read(0xF00F, 0, 64))
    traffic.plc.read(0xF00B, 0, info[1])
    group, offset, size = struct.unpack(
        "<III", traffic.plc.exchange(0xF007, 0, 12, b"MAIN.nCounter\0")
    )
    seen(decoder, traffic)
    traffic.plc.subscribe(group, offset, size, cycle_s=0.01)
    traffic.station.advance(0.01)
    assert texts(decoder, traffic) == [
        "watch MAIN.nCounter",
        "sample MAIN.nCounter = 0",
        "sample MAIN.nCounter = 1",
    ]


def test_types_that_are_learned_later_serve_what_is_watched_already(
    decoder: Decoder, traffic: Any
) -> None:
    traffic.plc.subscribe(0xF005, traffic.handle("MAIN.nCounter"), 4, cycle_s=0.01)
    traffic.plc.exchange(0xF009, 0, 200, b"MAIN.nCounter\0")
    traffic.station.advance(0.01)
    *_, sample = texts(decoder, traffic)
    assert sample == "sample MAIN.nCounter = 1"


def test_a_handle_requested_with_its_type_is_typed(decoder: Decoder, traffic: Any) -> None:
    answer = traffic.plc.exchange(0xF003, 0, 100, b"GVL.nInt\0")
    traffic.plc.read(0xF005, int.from_bytes(answer[:4], "little"), 2)
    assert texts(decoder, traffic)[1] == "read GVL.nInt = -16"


def test_after_an_online_change_nothing_old_is_reported(decoder: Decoder, traffic: Any) -> None:
    traffic.plc.read(0xF008, 0, 1)
    traffic.plc.exchange(0xF009, 0, 200, b"GVL.nInt\0")
    nint = struct.unpack("<III", traffic.plc.exchange(0xF007, 0, 12, b"GVL.nInt\0"))
    traffic.station.faults.add("online_change")
    traffic.station.advance(0.01)
    traffic.plc.read(*nint)
    traffic.plc.read(0xF008, 0, 1)
    traffic.plc.read(*nint)
    before, _, after = texts(decoder, traffic)[3:]
    assert before == "read GVL.nInt = -16"
    assert after == f"read data 0x{nint[0]:X}:0x{nint[1]:X} = f0 ff"


def test_other_ports_of_plcs_have_the_same_services(traffic: Any) -> None:
    names = Names(rows_of(traffic.station.devices))
    for port in (801, 852):
        row = names.row(port, 0xF003, 0)
        assert row is not None
        assert row.name == "symbol handle by name"


def test_samples_are_named_by_their_subscription(decoder: Decoder, traffic: Any) -> None:
    traffic.plc.exchange(0xF009, 0, 200, b"MAIN.nCounter\0")
    traffic.plc.subscribe(0xF005, traffic.handle("MAIN.nCounter"), 4, cycle_s=0.01)
    traffic.station.advance(0.02)
    assert texts(decoder, traffic)[2:] == [
        "watch MAIN.nCounter",
        "sample MAIN.nCounter = 0",
        "sample MAIN.nCounter = 1",
        "sample MAIN.nCounter = 2",
    ]


def test_commands_without_a_place(decoder: Decoder, traffic: Any) -> None:
    from achse.ams import Command
    from achse.ams.commands import EmptyRequest, WriteControlRequest

    traffic.plc.ask(Command.READ_DEVICE_INFO, EmptyRequest())
    traffic.plc.ask(Command.READ_STATE, EmptyRequest())
    traffic.plc.ask(Command.WRITE_CONTROL, WriteControlRequest(6, 0, b""))
    assert texts(decoder, traffic) == [
        "read device info = Plc30 App 3.1.4024",
        "read state = RUN, device state 0",
        "write control = STOP, device state 0",
    ]


def test_what_is_never_answered_is_reported(decoder: Decoder, traffic: Any) -> None:
    traffic.station.faults.add("drop", side="request")
    with pytest.raises(IndexError):
        traffic.plc.read(0x4020, 0, 4)
    assert seen(decoder, traffic) == []
    assert list(decoder.overdue(traffic.now)) == []
    [lost] = decoder.overdue(traffic.now + 1)
    assert (lost.answered, lost.duration_ns) == (False, None)
    assert list(decoder.overdue(traffic.now + 1)) == []


@given(st.lists(st.tuples(st.booleans(), st.binary(max_size=120)), max_size=8))
def test_whatever_passes_nothing_is_raised(packets: list[tuple[bool, bytes]]) -> None:
    decoder = Decoder(Names({}))
    for inwards, data in packets:
        for exchange in decoder.see(Captured(1, inwards, "peer", data)):
            exchange.as_json()


@given(st.integers(0, 10), st.booleans(), st.binary(max_size=60))
def test_whatever_is_in_a_frame_nothing_is_raised(command: int, answer: bool, data: bytes) -> None:
    from achse.ams import Frame

    decoder = Decoder(Names({}))
    request = Frame(bytes(8), bytes(8), command, 4, 0, 1, data)
    for frame in (request, request.reply(data)):
        for exchange in decoder.see(Captured(1, True, "peer", frame.encode())):
            exchange.as_json()
