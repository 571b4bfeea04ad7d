"""Registry of the system service: keys and values in memory."""

import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.devices.system.registry import MOST_BYTES, Registry
from achse.server import ServiceTable

LOCAL_MACHINE, DELETE = 200, 206
VALUES = 0xC000_0000
KEY = b"Software\\Test\\KeyA"


def _value(key: bytes, name: bytes, type: int, data: bytes) -> bytes:
    return b"%b\0%b\0%b%b" % (key, name, struct.pack("<I", type), data)


def _enumerate(client: Any, key: bytes, kind: int = 0, group: int = LOCAL_MACHINE) -> list[bytes]:
    entries: list[bytes] = []
    while True:
        answer = _answer(client.exchange, group, kind | len(entries), 0x800, key + b"\0")
        if isinstance(answer, int):
            assert answer == 0x70C
            return entries
        entries.append(answer)


def _answer(ask: Callable[..., Any], *arguments: object) -> Any:
    """What a request gives, or the code of its refusal."""
    try:
        return ask(*arguments)
    except DeviceError as refusal:
        return refusal.code


def test_value_is_read_by_name_and_enumerated(client: Any) -> None:
    client.write(LOCAL_MACHINE, 0, _value(KEY, b"SomeValueName", 1, b"SomeData\0"))
    client.write(LOCAL_MACHINE, 0, _value(KEY, b"", 4, b"\1\2\3\4"))
    assert client.exchange(LOCAL_MACHINE, 0, 64, KEY + b"\0somevaluename\0") == b"SomeData\0"
    assert _enumerate(client, KEY, VALUES) == [
        b"SomeValueName\0\1\0\0\0SomeData\0",
        b"\0\4\0\0\0\1\2\3\4",
    ]
    assert _enumerate(client, b"software") == [b"Test\0"]


def test_deleted_key_is_gone_with_the_keys_in_it(client: Any, refused: Any) -> None:
    client.write(LOCAL_MACHINE, 0, _value(KEY + b"\\SubKeyA", b"a", 1, b"\0"))
    client.write(LOCAL_MACHINE, 0, _value(KEY + b"2", b"a", 1, b"\0"))
    assert _enumerate(client, KEY) == [b"SubKeyA\0"]
    client.write(DELETE, 0, KEY + b"\0")
    with refused(0x1):
        client.write(DELETE, 0, KEY + b"\0")
    assert _enumerate(client, KEY) == []
    assert _enumerate(client, b"Software\\Test") == [b"KeyA2\0"]


@pytest.mark.parametrize("data", [KEY, KEY + b"\0abc", b"", b"a\\\\b\0"])
def test_deletion_of_what_is_no_key_is_refused(client: Any, refused: Any, data: bytes) -> None:
    client.write(LOCAL_MACHINE, 0, _value(KEY, b"a", 1, b"\0"))
    with refused(0x706):
        client.write(DELETE, 0, data)
    assert len(_enumerate(client, KEY, VALUES)) == 1


def test_hive_cannot_be_deleted(client: Any, refused: Any) -> None:
    with refused(0x1):
        client.write(DELETE, 0, b"\0")


@pytest.mark.parametrize(
    ("data", "code"),
    [(b"key", 0x706), (b"key\0name", 0x706), (b"key\0name\0\1\0\0", 0x705), (b"a\\" * 65, 0x706)],
)
def test_value_that_is_none_is_refused(client: Any, refused: Any, data: bytes, code: int) -> None:
    with refused(code):
        client.write(LOCAL_MACHINE, 0, data)


def test_missing_value_and_unknown_enumeration_are_refused(client: Any, refused: Any) -> None:
    client.write(LOCAL_MACHINE, 0, _value(KEY, b"a", 1, b"\0"))
    for code, offset, data in (
        (0x70C, 0, KEY + b"\0b\0"),
        (0x70C, 0, b"none\0a\0"),
        (0x70C, VALUES, b"none\0"),
        (0x703, 0x4000_0000, KEY + b"\0"),
        (0x706, 0, KEY),
    ):
        with refused(code):
            client.exchange(LOCAL_MACHINE, offset, 64, data)


@st.composite
def _operations(draw: st.DrawFn) -> list[tuple[int, tuple[bytes, ...], bytes, int, bytes, bool]]:
    """Hive, key, name of a value, type, data, whether the key is deleted instead."""
    names = st.sampled_from([b"a", b"A", b"b", b"\xe4", b"long name"])
    return draw(
        st.lists(
            st.tuples(
                st.sampled_from([200, 201, 202]),
                st.lists(names, min_size=1, max_size=4).map(tuple),
                st.one_of(names, st.just(b"")),
                st.integers(0, 0xFFFF_FFFF),
                st.sampled_from([0, 1, 300, MOST_BYTES // 3]).map(bytes),
                st.booleans(),
            ),
            max_size=12,
        )
    )


@settings(max_examples=60, deadline=None)
@given(_operations())
def test_registry_holds_what_was_written_and_not_deleted(
    operations: list[tuple[int, tuple[bytes, ...], bytes, int, bytes, bool]],
) -> None:
    """A model of paths and values; room that a deletion frees can be used again."""
    table = ServiceTable(Registry().groups())
    values: dict[tuple[int, tuple[bytes, ...], bytes], tuple[int, bytes]] = {}
    keys: set[tuple[int, tuple[bytes, ...]]] = set()
    for hive, path, name, type, data, deleted in operations:
        folded, text = tuple(step.lower() for step in path), b"\\".join(path)
        if deleted:
            within = {key for key in keys if key[0] == hive and key[1][: len(path)] == folded}
            answer = _answer(table.find(hive + 6).write, hive + 6, 0, text + b"\0", b"")
            assert answer == (None if within else 1)
            keys -= within
            values = {at: value for at, value in values.items() if (at[0], at[1]) not in within}
            continue
        stored = sum(len(value) for _, value in values.values())
        answer = _answer(table.find(hive).write, hive, 0, _value(text, name, type, data), b"")
        if answer is not None:
            assert answer == 0x70A
            assert stored + len(data) > MOST_BYTES - 20_000
            continue
        keys |= {(hive, folded[:count]) for count in range(1, len(path) + 1)}
        values[hive, folded, name.lower()] = type, data
    for (hive, path, name), (_, data) in values.items():
        requested = b"\\".join(path) + b"\0" + name + b"\0"
        assert table.find(hive).read_write(hive, 0, MOST_BYTES, requested, b"") == data
    assert sum(_count(table, hive, b"") for hive in (200, 201, 202)) == len(keys)


def _count(table: ServiceTable, hive: int, path: bytes) -> int:
    """Keys within a key, and those within them."""
    count = 0
    for number in range(100):
        answer = _answer(table.find(hive).read_write, hive, number, 99, path + b"\0", b"")
        if isinstance(answer, int):
            return number + count
        name = answer[:-1]
        count += _count(table, hive, path + b"\\" + name if path else name)
    raise AssertionError("more keys than were written")
