"""Names, handles, values and tables are served as real targets do."""

import struct
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.server import ClientLimits, TableSizes
from achse.server.symbols import SymbolServices

# handles ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [b"MAIN.nCounter", b"MAIN.nCounter\0", b"main.NCOUNTER\0rest"])
def test_a_name_gives_a_handle_with_or_without_nul(bench: Any, name: bytes) -> None:
    result, handle = bench.exchange(0xF003, 0, 4, name)
    assert result == 0
    assert len(handle) == 4
    assert handle != bytes(4)


def test_a_client_that_requests_more_than_a_handle_gets_size_and_type(bench: Any) -> None:
    result, answer = bench.exchange(0xF003, 0, 0xFFFF_FFFF, b"MAIN.nCounter")
    assert result == 0
    assert answer[4:] == struct.pack("<IIH", 4, 3, 4) + b"DINT\0"
    assert bench.read(0xF005, int.from_bytes(answer[:4], "little"), 4) == (0, bytes(4))


def test_each_request_gives_another_handle(bench: Any) -> None:
    assert len({bench.handle("MAIN.nCounter") for _ in range(3)}) == 3


@pytest.mark.parametrize(
    ("name", "length", "code"),
    [
        (b"MAIN.nothing", 4, 0x710),
        (b"", 4, 0x710),
        (b"\0", 4, 0x710),
        (b"x" * 10_000, 4, 0x710),
        (b"\xff\x81", 4, 0x710),
        (b"MAIN.a[9]", 4, 0x721),
        (b"MAIN.nCounter", 3, 0x705),
        (b"MAIN.nCounter", 0, 0x705),
    ],
)
def test_a_name_that_gives_no_handle(bench: Any, name: bytes, length: int, code: int) -> None:
    assert bench.exchange(0xF003, 0, length, name) == (code, b"")


def test_a_released_handle_cannot_be_used(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    assert bench.write(0xF006, 0, struct.pack("<I", handle)) == 0
    assert bench.read(0xF005, handle, 4) == (0x710, b"")
    assert bench.write(0xF005, handle, bytes(4)) == 0x710
    assert bench.write(0xF006, 0, struct.pack("<I", handle)) == 0x711


@pytest.mark.parametrize("data", [bytes(1), bytes(3), bytes(5)])
def test_a_release_has_four_bytes(bench: Any, data: bytes) -> None:
    assert bench.write(0xF006, 0, data) == 0x705


def test_release_without_a_handle_ends_what_the_client_has_abandoned(bench: Any) -> None:
    stranger, address = bench.join()
    abandoned = bench.handle("MAIN.nCounter")
    bench.device.symbols.handles.abandon_client(bytes(bench.me))
    own = bench.handle("MAIN.nCounter")
    assert bench.write(0xF006, 0, b"", source=address, origin=stranger) == 0
    assert bench.read(0xF005, abandoned, 4)[0] == 0
    assert bench.write(0xF006, 0, b"") == 0
    assert [bench.read(0xF005, each, 4)[0] for each in (own, abandoned)] == [0, 0x710]


def test_handle_is_used_by_all_clients_and_released_by_its_own(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    stranger, address = bench.join()
    way = {"source": address, "origin": stranger}
    assert bench.write(0xF005, handle, b"\7\0\0\0", **way) == 0
    assert bench.read(0xF005, handle, 4, **way) == (0, b"\7\0\0\0")
    assert bench.write(0xF006, 0, struct.pack("<I", handle), **way) == 0x711
    assert bench.read(0xF005, handle, 4) == (0, b"\7\0\0\0")
    bench.device.symbols_changed()
    assert bench.read(0xF005, handle, 4, **way) == (0x711, b"")


def test_handle_stays_valid_after_its_connection(bench: Any) -> None:
    """As command line tools use it: one process requests a handle, the next ones use it."""
    calls = []
    for request in ("request", "use", "release"):
        client, address = bench.join()
        way = {"source": address, "origin": client}
        if request == "request":
            value, method = (bench.handle(name, **way) for name in ("MAIN.text", "MAIN.fb#Sum"))
        elif request == "use":
            calls = [
                bench.write(0xF005, value, b"Hi\0", **way),
                bench.read(0xF005, value, 2, **way),
                bench.exchange(0xF005, method, 1, b"\1\2", **way),
            ]
        else:
            release = struct.pack("<I", value)
            codes = [bench.write(0xF006, 0, release, **way) for _ in range(2)]
        bench.router.unregister(address.port)
        bench.router.close_way(client)
    assert calls == [0, (0, b"Hi"), (0, b"\3")]
    assert codes == [0, 0x711]
    assert bench.exchange(0xF005, method, 1, b"\3") == (0, b"\3")
    assert bench.device.symbols.handles.usage.abandoned_handles == 1


def test_handles_are_limited_per_client(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(handles=2))
    first = bench.handle("MAIN.nCounter")
    bench.handle("MAIN.text")
    assert bench.exchange(0xF003, 0, 4, b"MAIN.text") == (0x716, b"")
    other, address = bench.join()
    bench.handle("MAIN.text", source=address, origin=other)
    bench.write(0xF006, 0, struct.pack("<I", first))
    bench.handle("MAIN.text")


def test_number_of_a_handle_in_use_is_not_given_again(bench: Any) -> None:
    handles = bench.device.symbols.handles
    handles._next = 0xFFFF_FFFF
    assert bench.handle("MAIN.nCounter") == 0xFFFF_FFFF
    handles._next = 0xFFFF_FFFF
    assert bench.handle("MAIN.nCounter") == 1
    bench.device.symbols_changed()
    handles._next = 0xFFFF_FFFF
    assert bench.handle("MAIN.nCounter") == 2


def test_symbol_of_a_handle_is_known_until_it_is_out_of_date(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    valid = bench.device.symbols.handles.valid
    assert valid[handle].symbol is bench.source.symbols["main.ncounter"]
    assert handle + 1 not in valid
    bench.device.symbols_changed()
    assert handle not in valid


def test_a_closed_port_abandons_its_handles_only(bench: Any) -> None:
    other, address = bench.join()
    bench.handle("MAIN.text", source=address, origin=other)
    handle = bench.handle("MAIN.nCounter")
    bench.device.symbols_changed()
    bench.handle("MAIN.text", source=address, origin=other)
    bench.router.unregister(address.port)
    handles = bench.device.symbols.handles
    assert (list(handles.clients), handles.usage.abandoned_handles) == ([bench.me], 2)
    assert bench.read(0xF005, handle, 4) == (0x711, b"")


def test_after_a_download_handles_are_out_of_date_until_released(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    bench.device.symbols_changed()
    assert bench.read(0xF005, handle, 4) == (0x711, b"")
    assert bench.write(0xF005, handle, bytes(4)) == 0x711
    assert bench.write(0xF006, 0, struct.pack("<I", handle)) == 0
    assert bench.read(0xF005, handle, 4) == (0x710, b"")
    assert list(bench.device.symbols.handles.clients) == []
    new = bench.handle("MAIN.nCounter")
    assert new != handle
    assert bench.read(0xF005, new, 4) == (0, bytes(4))


# values ----------------------------------------------------------------------------------------


def test_reads_are_cut_to_the_requested_length_and_to_the_symbol(bench: Any) -> None:
    bench.source.symbols["main.text"].memory[:5] = b"hello"
    handle = bench.handle("MAIN.text")
    assert bench.read(0xF005, handle, 5) == (0, b"hello")
    for length in (81, 1024, 0xFFFF_FFFF):
        assert bench.read(0xF005, handle, length) == (0, b"hello".ljust(81, b"\0"))


def test_length_zero_is_no_error(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    assert bench.read(0xF005, handle, 0) == (0, b"")
    assert bench.write(0xF005, handle, b"") == 0


def test_a_shorter_write_leaves_the_rest(bench: Any) -> None:
    text = bench.source.symbols["main.text"].memory
    text[:8] = b"abcdefgh"
    assert bench.write(0xF005, bench.handle("MAIN.text"), b"xy\0") == 0
    assert text[:8] == b"xy\0defgh"


def test_a_longer_write_is_refused_and_changes_nothing(bench: Any) -> None:
    assert bench.write(0xF005, bench.handle("MAIN.nCounter"), b"\1" * 5) == 0x705
    assert bench.source.symbols["main.ncounter"].number == 0


def test_a_read_only_symbol_cannot_be_written(bench: Any) -> None:
    assert bench.write(0xF005, bench.handle("MAIN.fixed"), b"\1\1") == 0x704


def test_a_value_by_name(bench: Any) -> None:
    bench.source.symbols["main.ncounter"].number = 77
    assert bench.exchange(0xF004, 0, 4, b"MAIN.nCounter") == (0, b"\x4d\0\0\0")
    assert bench.exchange(0xF004, 0, 0xFFFF, b"MAIN.nCounter\0") == (0, b"\x4d\0\0\0")
    assert bench.exchange(0xF004, 0, 2, b"MAIN.nCounter\0") == (0, b"\x4d\0")
    assert bench.exchange(0xF004, 0, 4, b"MAIN.nothing") == (0x710, b"")


def test_a_method_is_called_by_handle(bench: Any) -> None:
    handle = bench.handle("MAIN.fb#Sum")
    assert bench.exchange(0xF005, handle, 1, b"\1\2\3") == (0, b"\6")
    assert bench.exchange(0xF005, handle, 0, b"") == (0, b"")


def test_a_method_has_no_value_and_a_value_no_method(bench: Any) -> None:
    method, value = bench.handle("MAIN.fb#Sum"), bench.handle("MAIN.nCounter")
    assert bench.read(0xF005, method, 4) == (0x704, b"")
    assert bench.write(0xF005, method, b"") == 0x704
    assert bench.exchange(0xF004, 0, 4, b"MAIN.fb#Sum") == (0x704, b"")
    assert bench.raw(6, struct.pack("<IIIIII16x", 0xF005, method, 4, 4, 0, 0))[:4] == b"\4\7\0\0"
    assert bench.exchange(0xF005, value, 4, b"") == (0x704, b"")
    assert bench.exchange(0xF005, 12345, 4, b"") == (0x710, b"")


# tables ----------------------------------------------------------------------------------------


def test_info_by_name(bench: Any) -> None:
    answer = bench.exchange(0xF007, 0, 12, b"MAIN.nCounter")
    assert answer == (0, struct.pack("<III", 0x4040, 16, 4))


@pytest.mark.parametrize("length", [80, 798, 0xFFFF_FFFF])
def test_the_entry_of_a_symbol(bench: Any, length: int) -> None:
    entry = bench.source.symbols["main.ncounter"].entry()
    assert len(entry) == 40
    assert bench.exchange(0xF009, 0, length, b"MAIN.nCounter\0") == (0, entry)
    assert bench.exchange(0xF009, 0, 30, b"MAIN.nCounter") == (0, entry[:30])
    assert bench.exchange(0xF009, 0, 30, b"MAIN.nothing") == (0x710, b"")


def test_the_symbol_version(bench: Any) -> None:
    assert bench.read(0xF008, 0, 1) == (0, b"\7")
    assert bench.read(0xF008, 0, 4) == (0, b"\7")


def test_the_upload_info(bench: Any) -> None:
    assert bench.read(0xF00C, 0, 8) == (0, struct.pack("<II", 2, 160))


@pytest.mark.parametrize("length", [8, 24, 64, 100])
def test_the_second_upload_info_in_all_lengths(bench: Any, length: int) -> None:
    whole = struct.pack("<9I", 2, 160, 1, 96, 2000, 0, 0, 1252, 3) + bytes(28)
    assert len(whole) == 64
    assert bench.read(0xF00F, 0, length) == (0, whole[:length])


@pytest.mark.parametrize(("group", "table"), [(0xF00B, bytes(range(160))), (0xF00E, b"type" * 24)])
def test_a_table_is_uploaded_whole_or_in_pieces(bench: Any, group: int, table: bytes) -> None:
    assert bench.read(group, 0, len(table)) == (0, table)
    assert bench.read(group, 0, 0xFFFF_FFFF) == (0, table)
    assert bench.read(group, 0, 50) == (0, table[:50])
    pieces = [bench.read(group, 0x8000_0000 | at, 50)[1] for at in range(0, 200, 50)]
    assert b"".join(pieces) == table
    assert bench.read(group, 0xFFFF_FFFF, 0xFFFF_FFFF) == (0, b"")
    assert bench.read(group, 50, 50) == (0x703, b"")


def test_the_entry_of_a_type(bench: Any) -> None:
    assert bench.exchange(0xF011, 0, 0xFFFF_FFFF, b"DINT\0") == (0, b"DINT entry")
    assert bench.exchange(0xF011, 0, 100, b"Nothing") == (0x710, b"")
    assert bench.exchange(0xF011, 0, 100, b"") == (0x710, b"")


def test_a_symbol_notification_group_is_for_notifications_only(bench: Any) -> None:
    handle = bench.handle("MAIN.nCounter")
    assert bench.read(0xF010, handle, 4) == (0x704, b"")
    answer = bench.raw(6, struct.pack("<IIIIII16x", 0xF010, handle, 4, 4, 0, 0))
    assert answer == struct.pack("<II", 0, 1)
    assert bench.samples() == [(0, 1, bytes(4))]


@given(
    st.lists(st.sampled_from([b"MAIN.nCounter", b"MAIN.nCounter\0", b"main.NCOUNTER"]), max_size=9),
    st.data(),
)
def test_handles_of_one_spelling_share_a_symbol_until_the_table_changes(
    names: list[bytes], data: st.DataObject
) -> None:
    services = SymbolServices(_OneSymbol(), ClientLimits(), lambda: 0)

    def request(name: bytes) -> int:
        return int.from_bytes(services._handle_by_name(0, 4, name, bytes(8)), "little")

    handles = {request(name): name.rstrip(b"\0") for name in names}
    valid = services.handles.valid
    assert len({id(valid[each].symbol) for each in handles}) == len(set(handles.values()))
    released = data.draw(st.sets(st.sampled_from(sorted(handles)))) if handles else set()
    for handle in released:
        services.handles.release(handle, bytes(8))
    left = {name for handle, name in handles.items() if handle not in released}
    assert len(services.handles.symbols) == len(left)
    before = list({id(handle.symbol): handle.symbol for handle in valid.values()}.values())
    services.handles.invalidate()
    for name in left:
        assert valid[request(name)].symbol not in before


@pytest.mark.parametrize(("length", "is_shared"), [(1, True), (256, True), (257, False)])
def test_symbol_of_a_name_of_up_to_256_characters_is_shared(length: int, is_shared: bool) -> None:
    services = SymbolServices(_OneSymbol(), ClientLimits(), lambda: 0)
    for _ in range(2):
        services._handle_by_name(0, 4, b"x" * length, bytes(8))
    first, second = (handle.symbol for handle in services.handles.valid.values())
    assert (first is second) is is_shared
    assert len(services.handles.symbols) == is_shared


class _Connection:
    def __init__(self, connected: bool) -> None:
        self.connected = connected


@pytest.mark.parametrize(
    ("way", "count"), [(None, 1), (_Connection(True), 1), (_Connection(False), 0)]
)
def test_client_whose_connection_has_ended_gets_no_handle(way: Any, count: int) -> None:
    services = SymbolServices(_OneSymbol(), ClientLimits(), lambda: 0, lambda: way)
    refusal = nullcontext() if count else pytest.raises(DeviceError, match="connection has ended")
    with refusal:
        services._handle_by_name(0, 4, b"x", bytes(8))
    assert len(services.handles.valid) == count


def test_sample_of_a_value_is_cut_to_the_requested_length() -> None:
    services = SymbolServices(_OneSymbol(), ClientLimits(), lambda: 0)
    answer = services._handle_by_name(0, 4, b"x", bytes(8))
    handle = int.from_bytes(answer, "little")
    symbol = services.handles.find(handle).symbol
    for length in (2, 3):
        assert services._watch_value(handle, length, bytes(8)) == symbol.read
    assert services._watch_value(handle, 1, bytes(8))() == b"a"
    services._write_value(handle, b"", bytes(8))  # the symbol takes 1 byte or more


class _Value:
    """A symbol of two bytes."""

    index_group, index_offset, size, read_only, context, call = 0x4040, 0, 2, False, 0, None

    def read(self) -> bytes:
        return b"ab"

    def write(self, data: bytes) -> None:
        raise AssertionError

    def entry(self) -> bytes:
        raise AssertionError


class _OneSymbol:
    """A source that resolves every name to a new object."""

    version = 1

    def resolve(self, name: str) -> _Value:
        return _Value()

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=1, type_count=0)

    def symbol_table(self) -> bytes:
        return b""

    type_table = symbol_table

    def type_entry(self, name: str) -> None:
        return None
