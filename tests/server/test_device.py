"""A device answers every command, and every fault with a complete error reply."""

import logging
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AdsState, AmsAddress, DeviceError, Frame
from achse.ams.commands import AddNotificationRequest
from achse.server import DIRECT_CODES_OF_A_PLC, ClientLimits

FULL_LENGTH = {1: 24, 2: 8, 3: 4, 4: 8, 5: 4, 6: 8, 7: 4, 9: 8}
"""Bytes of an error reply per command: the whole layout, real clients parse it."""


# every command, byte by byte -------------------------------------------------------------------


def test_read_device_info(bench: Any) -> None:
    assert bench.raw(1, b"") == bytes.fromhex(
        "00000000 03 01 b80f 506c633330204170700000000000 0000"
    )


def test_read(bench: Any) -> None:
    answer = bench.raw(2, struct.pack("<III", 0x4020, 3, 4))
    assert answer == bytes.fromhex("00000000 04000000 03040506")


def test_write(bench: Any) -> None:
    request = struct.pack("<III", 0x4020, 3, 2) + b"\xaa\xbb"
    assert bench.raw(3, request) == bytes(4)
    assert bench.memory[2:6] == b"\x02\xaa\xbb\x05"


def test_read_state(bench: Any) -> None:
    bench.device.ads_state, bench.device.device_state = AdsState.RUN, 1
    assert bench.raw(4, b"") == bytes.fromhex("00000000 0500 0100")


def test_write_control(bench: Any) -> None:
    assert bench.raw(5, struct.pack("<HHI", 6, 2, 0)) == bytes(4)
    assert bench.raw(4, b"") == bytes.fromhex("00000000 0600 0200")


def test_write_control_takes_extra_data(bench: Any) -> None:
    assert bench.raw(5, struct.pack("<HHI", 6, 0, 10_240) + bytes(10_240)) == bytes(4)


def test_write_control_leads_where_the_device_says(bench: Any) -> None:
    assert bench.raw(5, struct.pack("<HHI", 2, 0, 0)) == bytes(4)
    assert bench.device.ads_state is AdsState.STOP


@pytest.mark.parametrize(
    ("state", "code"), [(0, 0x701), (20, 0x701), (0xFFFF, 0x701), (15, 0x712), (16, 0x712)]
)
def test_a_state_that_is_none_or_not_possible(bench: Any, state: int, code: int) -> None:
    assert bench.raw(5, struct.pack("<HHI", state, 0, 0)) == struct.pack("<I", code)
    assert bench.device.ads_state is AdsState.RUN


def test_add_and_delete_notification(bench: Any) -> None:
    body = struct.pack("<IIIIII", 0x4020, 0, 4, 4, 0, 0) + b"\xcc" * 16
    assert bench.raw(6, body) == struct.pack("<II", 0, 1)
    assert bench.raw(7, struct.pack("<I", 1)) == bytes(4)
    assert bench.raw(7, struct.pack("<I", 1)) == struct.pack("<I", 0x714)


def test_read_write(bench: Any) -> None:
    answer = bench.raw(9, struct.pack("<IIII", 0xF003, 0, 4, 13) + b"MAIN.nCounter")
    assert answer[:8] == bytes.fromhex("00000000 04000000")
    assert answer[8:] != bytes(4)


# faults ----------------------------------------------------------------------------------------


def test_an_unknown_command_is_answered_by_the_header(bench: Any) -> None:
    for command in (0, 10, 0x4711, 0xFFFF):
        bench.send(command, b"abc")
        (answer,) = bench.client.frames
        assert (answer.error, answer.flags, answer.data) == (8, 5, b"")
        bench.client.frames.clear()


@pytest.mark.parametrize(
    ("command", "data"),
    [
        (1, b"\0"),
        (2, b""),
        (2, bytes(11)),
        (2, bytes(13)),
        (3, bytes(11)),
        (3, struct.pack("<III", 0x4020, 0, 2) + b"\0"),
        (3, struct.pack("<III", 0x4020, 0, 2) + bytes(3)),
        (3, struct.pack("<III", 0x4020, 0, 0xFFFF_FFFF)),
        (4, b"\0"),
        (5, bytes(7)),
        (5, struct.pack("<HHI", 6, 0, 1)),
        (5, struct.pack("<HHI", 6, 0, 0) + b"\0"),
        (6, bytes(39)),
        (6, bytes(41)),
        (7, bytes(3)),
        (7, bytes(5)),
        (9, bytes(15)),
        (9, struct.pack("<IIII", 0xF003, 0, 4, 2) + b"a"),
        (9, struct.pack("<IIII", 0xF003, 0, 4, 0) + b"a"),
    ],
)
def test_a_malformed_request_is_answered_0x705(bench: Any, command: int, data: bytes) -> None:
    answer = bench.raw(command, data)
    assert answer == struct.pack("<I", 0x705).ljust(FULL_LENGTH[command], b"\0")


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ((2, struct.pack("<III", 0x4711, 0, 4)), 0x702),
        ((2, struct.pack("<III", 0x1000, 99, 4)), 0x703),
        ((3, struct.pack("<IIIH", 0x1000, 2, 2, 0)), 0x704),
        ((3, struct.pack("<IIIH", 0x1000, 1, 2, 0)), 0x705),
        ((3, struct.pack("<IIId", 0x1000, 1, 8, 100.5)), 0x4221),
        ((9, struct.pack("<IIII", 0x1000, 1, 8, 0)), 0x704),
        ((6, struct.pack("<IIIIII16x", 0x4711, 0, 4, 4, 0, 0)), 0x702),
        ((6, struct.pack("<IIIIII16x", 0x4020, 64, 4, 4, 0, 0)), 0x703),
    ],
)
def test_a_refusal_has_its_code_and_full_length(
    bench: Any, request_: tuple[int, bytes], code: int
) -> None:
    command, data = request_
    answer = bench.raw(command, data)
    assert answer == struct.pack("<I", code).ljust(FULL_LENGTH[command], b"\0")


def test_a_plc_prefers_0x701_except_inside_sums(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(direct_codes=DIRECT_CODES_OF_A_PLC)
    group_zero = struct.pack("<III", 0, 0, 4)
    assert bench.raw(2, group_zero) == struct.pack("<II", 0x701, 0)
    assert bench.raw(2, struct.pack("<III", 0x4020, 0x1_0000, 4)) == struct.pack("<II", 0x701, 0)
    assert bench.raw(6, struct.pack("<IIIIII16x", 0, 0, 4, 4, 0, 0)) == struct.pack("<II", 0x701, 0)
    assert bench.exchange(0xF080, 1, 8, group_zero) == (0, struct.pack("<II", 0x702, 0))
    with pytest.raises(DeviceError) as failure:
        bench.device.read(0, 0, 4)
    assert failure.value.code == 0x702


def test_a_fault_in_a_row_is_logged_and_answered(
    bench: Any, caplog: pytest.LogCaptureFixture
) -> None:
    assert bench.raw(2, struct.pack("<III", 0x1000, 3, 2)) == struct.pack("<II", 1, 0)
    assert f"Plc30 App: READ of {bench.me} failed" in caplog.text
    assert "ZeroDivisionError" in caplog.text


def test_a_refusal_is_logged_with_its_client(bench: Any, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, logger="achse.server"):
        bench.raw(2, struct.pack("<III", 0x9999, 3, 2))
    [record] = caplog.records
    assert f"READ of {bench.me} refused: 0x9999: 0x702" in record.getMessage()
    assert record.client == str(bench.me)  # type: ignore[attr-defined]


def test_a_request_without_wish_for_an_answer_gets_none(bench: Any) -> None:
    for command, data in (
        (3, struct.pack("<III", 0x4020, 0, 1) + b"\x99"),
        (3, b""),
        (77, b""),
    ):
        bench.router.deliver(Frame(bench.address, bench.me, command, 6, 0, 1, data))
    assert bench.client.frames == []
    assert bench.memory[0] == 0x99


def test_responses_and_notifications_are_not_answered(bench: Any) -> None:
    for command, flags in ((2, 5), (8, 4), (99, 5)):
        bench.router.deliver(Frame(bench.address, bench.me, command, flags, 0, 1, b""))
    assert bench.client.frames == []


@given(command=st.integers(0, 12), data=st.binary(max_size=120))
def test_any_bytes_get_a_complete_answer(
    make_bench: Callable[..., Any], command: int, data: bytes
) -> None:
    check_answered(make_bench(), command, data)


header = st.tuples(
    st.sampled_from(
        [0x1000, 0x4020, *range(0xF000, 0xF013), *range(0xF080, 0xF088), 0xF100, 0x4711]
    ),
    st.integers(0, 4) | st.integers(0, 0xFFFF_FFFF),
    st.integers(0, 100) | st.integers(0, 0xFFFF_FFFF),
)
body = st.binary(max_size=64) | st.lists(header, max_size=6).map(
    lambda parts: b"".join(struct.pack("<III", *part) for part in parts)
)


@given(head=header, data=body, command=st.sampled_from([2, 3, 6, 9]))
def test_any_well_formed_request_gets_a_complete_answer(
    make_bench: Callable[..., Any], head: tuple[int, int, int], data: bytes, command: int
) -> None:
    group, offset, _ = head
    check_answered(
        make_bench(),
        command,
        {
            2: struct.pack("<III", *head),
            3: struct.pack("<III", group, offset, len(data)) + data,
            6: struct.pack("<III", *head) + data[:28].ljust(28, b"\0"),
            9: struct.pack("<IIII", *head, len(data)) + data,
        }[command],
    )


def check_answered(bench: Any, command: int, data: bytes) -> None:
    """One answer of full length, not longer than asked, before any notification."""
    logging.disable(logging.CRITICAL)
    try:
        bench.send(command, data)
        bench.tick()
    finally:
        logging.disable(logging.NOTSET)
    if command == 8:
        return
    answer = bench.client.frames[0]
    assert answer.flags == 5
    assert answer.invoke_id == bench.invoke_id
    if command not in FULL_LENGTH:
        assert (answer.error, answer.data) == (8, b"")
        return
    assert answer.error == 0
    (result,) = struct.unpack_from("<I", answer.data)
    if result or command not in (2, 9):
        assert len(answer.data) == FULL_LENGTH[command]
    else:
        (length,) = struct.unpack_from("<I", answer.data, 4)
        (requested,) = struct.unpack_from("<I", data, 8)
        assert len(answer.data) == 8 + length
        assert length <= requested
    for notification in bench.client.frames[1:]:
        assert notification.command == 8


# state group -----------------------------------------------------------------------------------


def test_the_state_can_be_read_as_data(bench: Any) -> None:
    bench.device.ads_state, bench.device.device_state = AdsState.STOP, 3
    assert bench.read(0xF100, 0, 4) == (0, b"\6\0\3\0")
    assert bench.read(0xF100, 0, 2) == (0, b"\6\0")
    assert bench.read(0xF100, 2, 2) == (0, b"\3\0")
    assert bench.read(0xF100, 1, 2) == (0x703, b"")
    assert bench.write(0xF100, 0, b"\5\0") == 0x704


# router ----------------------------------------------------------------------------------------


def test_a_device_answers_on_each_of_its_ports(bench: Any) -> None:
    second = bench.device.attach(bench.router, 801)
    assert (bench.device.address.port, second.port) == (851, 801)
    for port in (851, 801):
        to = AmsAddress.of(bench.router.net_id, port)
        bench.router.deliver(Frame(to, bench.me, 4, 4, 0, 9, b""))
        assert bench.client.frames.pop().source == to


def test_the_answer_comes_from_the_address_that_was_queried(bench: Any) -> None:
    alias = AmsAddress("127.0.0.1.1.1:851")
    request = AddNotificationRequest(0x4020, 0, 1, 3, 0, 0)
    bench.router.deliver(Frame(alias, bench.me, 6, 4, 0, 9, request.encode()))
    bench.tick(10)
    assert {frame.source for frame in bench.client.frames} == {alias}
    assert len(bench.client.frames) == 3


def test_a_detached_device_is_gone(bench: Any) -> None:
    bench.handle("MAIN.nCounter")
    bench.device.detach()
    bench.send(4, b"")
    assert bench.client.frames.pop().error == 6
    assert len(bench.device.symbols.handles) == 0
    with pytest.raises(LookupError):
        _ = bench.device.address


def test_a_device_belongs_to_one_router(bench: Any, make_bench: Callable[..., Any]) -> None:
    with pytest.raises(ValueError, match="one router"):
        bench.device.attach(make_bench().router, 852)


# in this process -------------------------------------------------------------------------------


def test_the_core_serves_callers_in_this_process(bench: Any) -> None:
    device = bench.device
    assert device.read(0x4020, 1, 2) == b"\1\2"
    device.write(0x4020, 1, b"\7")
    assert device.read(0x4020, 1, 2) == b"\7\2"
    handle = int.from_bytes(device.read_write(0xF003, 0, 4, b"main.ncounter"), "little")
    assert device.read(0xF005, handle, 4) == bytes(4)
    with pytest.raises(DeviceError) as failure:
        device.add_notification(AddNotificationRequest(0x4020, 0, 1, 4, 0, 0), b"")
    assert failure.value.code == 0x715


def test_the_whole_table_can_be_listed(bench: Any) -> None:
    facts = list(bench.device.services.describe())
    groups = {row.index_group for row in facts}
    assert {0x1000, 0x4020, 0xF100, *range(0xF003, 0xF00A), *range(0xF080, 0xF087)} <= groups
    assert all(row.name for row in facts)


# clients that are gone -------------------------------------------------------------------------


def test_closed_port_ends_its_subscriptions_and_abandons_its_handles(bench: Any) -> None:
    bench.subscribe("MAIN.nCounter")
    bench.router.unregister(bench.me.port)
    assert len(bench.device.notifications) == 0
    handles = bench.device.symbols.handles
    assert (list(handles.clients), handles.usage.abandoned_handles) == ([], 1)


def test_a_client_out_of_reach_is_dropped_after_a_minute(bench: Any) -> None:
    remote = AmsAddress("192.168.0.9.1.1:30001")
    connection, _ = bench.join()
    bench.router.learn(remote, connection)
    bench.subscribe("MAIN.nCounter", source=remote, origin=connection)
    bench.tick(2000)
    bench.router.forget(remote, connection)
    connection.open = False
    bench.tick(59_000)
    assert len(bench.device.notifications) == 1
    bench.tick(3_000)
    assert len(bench.device.notifications) == 0
    assert list(bench.device.symbols.handles.clients) == []


def test_subscriptions_end_with_their_connection_though_the_address_is_used_again(
    bench: Any,
) -> None:
    remote = AmsAddress("192.168.0.9.1.1:30001")
    first, second = bench.join()[0], bench.join()[0]
    ways = [{"source": remote, "origin": way} for way in (first, second)]
    handles = []
    for way in ways:
        bench.router.learn(remote, way["origin"])
        handles.append(bench.handle("MAIN.nCounter", **way))
        bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, **way)
    second.frames.clear()
    bench.router.forget(remote, first)
    bench.router.close_way(first)
    assert len(bench.device.notifications) == 1
    bench.tick(1000)
    assert {sample[1] for sample in bench.samples(second)} == {2}
    results = [bench.read(0xF005, handle, 4, **ways[1])[0] for handle in handles]
    assert results == [0, 0]
    bench.router.close_way(second)
    bench.tick(1000)
    assert len(bench.device.notifications) == 0
    assert bench.device.symbols.handles.usage.abandoned_handles == 4
    usage = bench.device.notifications.usage
    assert (usage.notifications, usage.watched, usage.queued) == (0, 0, 0)


def test_much_that_was_made_over_a_connection_ends_in_slices(
    make_bench: Callable[..., Any],
) -> None:
    bench = make_bench(ClientLimits(abandoned_handles=100))
    remote = AmsAddress("192.168.0.9.1.1:30001")
    way, _ = bench.join()
    notifications = bench.device.notifications
    for _ in range(5000):
        notifications.add(remote, bench.address, way, lambda: b"x", 1, 3, 0, 0)
    notifications.send_first()
    for _ in range(25_000):
        bench.handle("MAIN.nCounter", source=remote, origin=way)
    way.frames.clear()
    bench.router.close_way(way)
    assert (len(notifications), list(notifications.clients)) == (0, [])
    assert len(notifications._subscriptions) == 4000
    assert len(bench.device.symbols.handles) == 15_000
    assert bench.raw(7, struct.pack("<I", 1), source=remote) == struct.pack("<I", 0x714)
    bench.tick(50)
    assert len(notifications._subscriptions) == 0
    bench.tick(3000)
    assert len(bench.device.symbols.handles) == 100
    assert way.frames == []
