"""SDO transfers of every kind against a dictionary in memory."""

import struct
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode
from achse.ethercat.dictionary import DictionaryEntry, DictionaryObject
from achse.ethercat.loopback import Loopback
from achse.ethercat.sdo import MAX_TRANSFER, SdoServer

CAPACITY = 48
TEXT = 0x2000


class Client:
    """The client's end, written from the protocol and not from the server."""

    def __init__(self, application: Loopback) -> None:
        objects = {each.index: each for each in application.objects()}
        self.server = SdoServer(application, objects)

    def ask(self, request: bytes) -> bytes:
        reply, aborted = self.server.answer(request.ljust(8, b"\0"), CAPACITY)
        assert reply is not None
        assert len(reply) <= CAPACITY
        assert len(reply) >= 8
        assert aborted == (reply[0] == 0x80)
        return reply

    def abort(self, request: bytes) -> AbortCode | None:
        reply = self.ask(request)
        return AbortCode.of(int.from_bytes(reply[4:8], "little")) if reply[0] == 0x80 else None

    def read(self, index: int, subindex: int, complete: bool = False) -> bytes | AbortCode | None:
        reply = self.ask(struct.pack("<BHB", 0x40 | 0x10 * complete, index, subindex))
        if reply[0] == 0x80:
            return AbortCode.of(int.from_bytes(reply[4:8], "little"))
        assert reply[1:4] == struct.pack("<HB", index, subindex)
        assert reply[0] & 0x10 == 0x10 * complete
        if reply[0] & 0x02:
            return reply[4 : 8 - (reply[0] >> 2 & 3)]
        size = int.from_bytes(reply[4:8], "little")
        data = reply[8 : 8 + size]
        toggle = 0
        while len(data) < size:
            part = self.ask(bytes((0x60 | toggle,)))
            assert part[0] >> 5 == 0
            assert part[0] & 0x10 == toggle
            unused = part[0] >> 1 & 7 if len(part) == 8 else 0
            data += part[1 : len(part) - unused]
            assert bool(part[0] & 1) == (len(data) >= size)
            toggle ^= 0x10
        return data

    def write(
        self, index: int, subindex: int, data: bytes, complete: bool = False, first: int = 20
    ) -> AbortCode | None:
        command = 0x21 | 0x10 * complete
        head = struct.pack("<BHBI", command, index, subindex, len(data))
        reply = self.ask(head + data[:first])
        rest = data[first:]
        toggle = 0
        while rest and reply[0] != 0x80:
            part, rest = rest[:30], rest[30:]
            unused = 7 - len(part) if len(part) < 7 else 0
            command = toggle | unused << 1 | (not rest)
            reply = self.ask(bytes((command,)) + part.ljust(7, b"\0"))
            assert reply[0] in (0x20 | toggle, 0x80)
            toggle ^= 0x10
        return AbortCode.of(int.from_bytes(reply[4:8], "little")) if reply[0] == 0x80 else None


@pytest.fixture
def application() -> Loopback:
    return Loopback()


@pytest.fixture
def client(application: Loopback) -> Client:
    return Client(application)


@given(st.binary(max_size=200))
def test_what_is_written_is_read(data: bytes) -> None:
    application = Loopback()
    client = Client(application)
    assert client.write(TEXT, 0, data) is None
    assert application.text == data
    assert client.read(TEXT, 0) == data


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_expedited(client: Client, application: Loopback, size: int) -> None:
    data = bytes(range(1, size + 1))
    command = {1: 0x2F, 2: 0x2B, 3: 0x27, 4: 0x23}[size]
    reply = client.ask(struct.pack("<BHB", command, TEXT, 0) + data)
    assert reply == struct.pack("<BHBI", 0x60, TEXT, 0, 0)
    assert application.text == data
    answer = client.ask(struct.pack("<BHB", 0x40, TEXT, 0))
    assert answer[0] == {1: 0x4F, 2: 0x4B, 3: 0x47, 4: 0x43}[size]
    assert answer[4:] == data.ljust(4, b"\0")


def test_expedited_without_size_takes_the_entrys_size(client: Client) -> None:
    assert client.abort(struct.pack("<BHB", 0x22, 0x7000, 2) + b"\x07\0\0\0") is None
    assert client.read(0x7000, 2) == b"\x07"


def test_a_write_reads_back_in_its_own_entry_only(client: Client) -> None:
    assert client.write(0x7000, 3, b"\x55") is None
    assert [client.read(0x7000, n) for n in range(5)] == [b"\x04", b"\0", b"\0", b"\x55", b"\0"]


@pytest.mark.parametrize(
    ("request_bytes", "code"),
    [
        ("40 0050 00", AbortCode.NO_OBJECT),
        ("40 1810 05", AbortCode.NO_SUBINDEX),
        ("23 1810 01 00000000", AbortCode.READ_ONLY),
        ("23 0070 01 00000000", AbortCode.LENGTH),
        ("21 0050 00 ff000000", AbortCode.NO_OBJECT),
        ("21 0020 00 01000100", AbortCode.MEMORY),
        ("50 0020 00", AbortCode.UNSUPPORTED_ACCESS),
        ("50 1810 02", AbortCode.UNSUPPORTED_ACCESS),
        ("50 0050 00", AbortCode.NO_OBJECT),
        ("60", AbortCode.COMMAND),
        ("00", AbortCode.COMMAND),
        ("a0 0020 00", AbortCode.COMMAND),
        ("c0 0020 00", AbortCode.COMMAND),
        ("e0 0020 00", AbortCode.COMMAND),
    ],
)
def test_aborts(client: Client, request_bytes: str, code: AbortCode) -> None:
    assert client.abort(bytes.fromhex(request_bytes)) is code


def test_the_longest_transfer(client: Client, application: Loopback) -> None:
    data = bytes(MAX_TRANSFER)
    assert client.write(TEXT, 0, data) is None
    assert len(application.text) == MAX_TRANSFER


@pytest.mark.parametrize("upload", [True, False])
def test_a_wrong_toggle_ends_the_transfer(
    client: Client, application: Loopback, upload: bool
) -> None:
    application.text = bytes(100)
    command = 0x40 if upload else 0x21
    client.ask(struct.pack("<BHBI", command, TEXT, 0, 100))
    segment = 0x70 if upload else 0x10
    assert client.abort(bytes((segment,))) is AbortCode.TOGGLE
    assert client.abort(bytes((segment & 0x60,))) is AbortCode.COMMAND


def test_the_other_directions_segment_is_refused(client: Client, application: Loopback) -> None:
    application.text = bytes(100)
    client.ask(struct.pack("<BHB", 0x40, TEXT, 0))
    assert client.abort(b"\x00") is AbortCode.COMMAND


@pytest.mark.parametrize(("size", "code"), [(5, AbortCode.TOO_LONG), (9, AbortCode.TOO_SHORT)])
def test_segments_must_fill_the_announced_size(
    client: Client, application: Loopback, size: int, code: AbortCode
) -> None:
    head = struct.pack("<BHBI", 0x21, TEXT, 0, size)
    reply, _ = client.server.answer(head, CAPACITY)
    assert reply is not None
    assert reply[0] == 0x60
    assert client.abort(b"\x01" + bytes(7)) is code
    assert application.text == b"any text"


def test_an_abort_of_the_client_ends_the_transfer_without_answer(
    client: Client, application: Loopback
) -> None:
    application.text = bytes(100)
    client.ask(struct.pack("<BHB", 0x40, TEXT, 0))
    assert client.server.answer(struct.pack("<BHBI", 0x80, TEXT, 0, 0), CAPACITY) == (None, False)
    assert client.abort(b"\x60") is AbortCode.COMMAND


def test_a_new_request_ends_the_transfer(client: Client, application: Loopback) -> None:
    application.text = bytes(100)
    client.ask(struct.pack("<BHB", 0x40, TEXT, 0))
    assert client.read(0x1018, 4) == bytes(4)
    assert client.abort(b"\x60") is AbortCode.COMMAND


def test_complete_access_equals_single_reads(client: Client, application: Loopback) -> None:
    for each in application.objects():
        if len(each.entries) == 1:
            continue
        parts = [client.read(each.index, entry.subindex) for entry in each.entries]
        assert all(isinstance(part, bytes) for part in parts)
        count, *entries = [part for part in parts if isinstance(part, bytes)]
        whole = b"".join(entries)
        assert client.read(each.index, 0, complete=True) == count + b"\0" + whole
        assert client.read(each.index, 1, complete=True) == whole


class Mapping(Loopback):
    """A loopback with a list whose length the master sets, as PDO mappings have."""

    def __init__(self) -> None:
        super().__init__()
        rw, u8, u16 = 0x3F, 5, 6
        numbers = [DictionaryEntry(n, f"Entry {n}", u16, 16, rw) for n in range(1, 5)]
        entries = (DictionaryEntry(0, "Count", u8, 8, rw), *numbers)
        self.mapping = DictionaryObject(0x1C12, "List", 8, u16, entries)
        self.values = {0: b"\x02", 1: b"11", 2: b"22", 3: b"33", 4: b"44"}
        self.writes: list[tuple[int, bytes]] = []

    def objects(self) -> tuple[DictionaryObject, ...]:
        rest = [each for each in super().objects() if each.index != 0x1C12]
        return (*rest, self.mapping)

    def read_object(self, index: int, subindex: int) -> bytes:
        return self.values[subindex] if index == 0x1C12 else super().read_object(index, subindex)

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        self.writes.append((subindex, data))
        self.values[subindex] = data


def test_a_list_is_read_up_to_its_length() -> None:
    assert Client(Mapping()).read(0x1C12, 0, complete=True) == b"\x02\x001122"


def test_a_list_is_emptied_written_and_gets_its_length() -> None:
    application = Mapping()
    assert Client(application).write(0x1C12, 0, b"\x03\x00aabbcc", complete=True) is None
    assert application.writes == [
        (0, b"\0"),
        (1, b"aa"),
        (2, b"bb"),
        (3, b"cc"),
        (0, b"\x03"),
    ]


def test_more_data_than_the_length_says_is_left_alone() -> None:
    application = Mapping()
    assert Client(application).write(0x1C12, 0, b"\x01\x00aabb", complete=True) is None
    assert application.writes == [(0, b"\0"), (1, b"aa"), (0, b"\x01")]


@pytest.mark.parametrize("data", [b"\x01", b"\x02\x00aab"])
def test_complete_access_with_half_an_entry_is_refused(data: bytes) -> None:
    assert Client(Mapping()).write(0x1C12, 0, data, complete=True) is AbortCode.LENGTH


@given(st.lists(st.binary(min_size=8, max_size=CAPACITY), max_size=20))
def test_any_bytes_get_an_answer(requests: list[bytes]) -> None:
    server: Callable[[bytes, int], tuple[bytes | None, bool]] = Client(Loopback()).server.answer
    for request in requests:
        reply, _ = server(request, CAPACITY)
        assert reply is None or 8 <= len(reply) <= CAPACITY
