"""Rights: what each request needs, also inside sums; what nobody knows needs all."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right, needed_rights, rights_named

READ, WRITE, METHODS, FILES, STATE = (
    Right.READ,
    Right.WRITE,
    Right.METHODS,
    Right.FILES,
    Right.STATE,
)


def request(command: int, *words: int, port: int = 851, data: bytes = b"") -> Frame:
    body = struct.pack(f"<{len(words)}I", *words) + data
    target, source = AmsAddress(f"5.1.2.3.1.1:{port}"), AmsAddress("192.0.2.7.1.1:30000")
    return Frame(bytes(target), bytes(source), command, data=body)


def sum_of(group: int, *parts: tuple[int, ...]) -> Frame:
    data = b"".join(struct.pack(f"<{len(part)}I", *part) for part in parts)
    return request(Command.READ_WRITE, group, len(parts), 0, len(data), data=data)


PARTS = struct.pack("<8I", 0xF003, 0, 4, 3, 0xF005, 1, 4, 3)


@pytest.mark.parametrize(
    ("frame", "needed"),
    [
        (request(Command.READ_DEVICE_INFO), READ),
        (request(Command.READ_STATE), READ),
        (request(Command.READ, 0x4020, 0, 4), READ),
        (request(Command.ADD_NOTIFICATION, 0x4020, 0, 4), READ),
        (request(Command.DELETE_NOTIFICATION, 120), READ),
        (request(Command.WRITE, 0x4020, 0, 4), WRITE),
        (request(Command.WRITE, 0xF004, 0, 4), WRITE),
        (request(Command.WRITE, 0xF006, 0, 4), READ),
        (request(Command.WRITE, 0x4201, 0x20, 4, port=500), WRITE),
        (request(Command.WRITE_CONTROL, 5), STATE),
        (request(Command.READ_WRITE, 0xF003, 0, 4), READ),
        (request(Command.READ_WRITE, 0xF009, 0, 4), READ),
        (request(Command.READ_WRITE, 0xF005, 1, 4), METHODS),
        (request(Command.READ_WRITE, 0x4020, 1, 4), READ | WRITE),
        (request(Command.READ, 120, 0, 4, port=10_000), FILES),
        (request(Command.READ_WRITE, 133, 0, 4, port=10_000), FILES),
        (request(Command.WRITE, 123, 0, 4, port=10_000), FILES),
        (request(Command.READ_WRITE, 100, 0, 4, port=10_000), FILES),
        (request(Command.WRITE, 111, 0, 4, port=10_000), FILES),
        (request(Command.READ, 0xF600, 0, 4, port=10_000), FILES),
        (request(Command.WRITE, 0xF6FF, 0, 4, port=10_000), FILES),
        (request(Command.READ, 0xFA01, 0, 4, port=26_000), READ),
        (request(Command.READ_WRITE, 0xF080, 1, 4, port=26_000), READ),
        (request(Command.READ_WRITE, 0xFA01, 0, 4, port=26_000), ALL_RIGHTS),
        (request(Command.WRITE, 0xFA01, 0, 4, port=26_000), ALL_RIGHTS),
        (request(Command.READ_WRITE, 0xFA05, 0, 4, port=26_000), ALL_RIGHTS),
        (request(Command.READ_WRITE, 0xF082, 1, 4, port=26_000), ALL_RIGHTS),
        (request(Command.READ, 800, 0, 4, port=10_000), READ),
        (request(Command.READ_WRITE, 0xF080, 1, 4, port=10_000), FILES | READ),
        (request(Command.READ_WRITE, 0xF081, 1, 4, port=10_000), ALL_RIGHTS),
        (request(Command.READ_WRITE, 0xF082, 1, 4, port=10_000), ALL_RIGHTS),
        (request(Command.WRITE, 500, 0, 4, port=10_000), ALL_RIGHTS),
        (request(Command.WRITE, 801, 0, 4, port=10_000), ALL_RIGHTS),
        (request(Command.WRITE, 802, 0, 4, port=10_000), ALL_RIGHTS),
        (request(Command.READ, 803, 0, 4, port=10_000), READ),
        (request(Command.READ_WRITE, 600, 0, 4, port=10_000), READ | WRITE),
        (sum_of(0xF080, (0x4020, 0, 4)), READ),
        (sum_of(0xF081, (0x4020, 0, 4)), WRITE),
        (sum_of(0xF081, (0xF006, 0, 4), (0xF006, 0, 4)), READ),
        (sum_of(0xF081, (0xF006, 0, 4), (0x4020, 0, 4)), READ | WRITE),
        (sum_of(0xF082, (0xF003, 0, 4, 3), (0xF003, 0, 4, 3)), READ),
        (sum_of(0xF082, (0xF003, 0, 4, 3), (0xF005, 1, 4, 3)), READ | METHODS),
        (sum_of(0xF082, (0x4020, 0, 4, 3)), READ | WRITE),
        (request(Command.WRITE, 0xF080, 1, 4, port=10_000), WRITE),
        (request(Command.READ, 801, 0, 4, port=10_000), READ),
        (request(Command.WRITE, 0xF006), READ),
        (request(Command.WRITE, data=b"\x06\xf0\0"), WRITE),
        (sum_of(0xF081), WRITE),
        (sum_of(0xF082, *[(0xF003, 0, 4, 3)] * 499, (0xF005, 1, 4, 3)), READ | METHODS),
        (sum_of(0xF082, *[(0xF003, 0, 4, 3)] * 500, (0xF005, 1, 4, 3)), READ),
        (
            request(Command.READ_WRITE, 0xF082, 1, 4, 32, data=PARTS),
            READ,  # the second part is behind the number of parts
        ),
        (request(Command.READ_WRITE, 0x4020, 1, 4, 32, data=PARTS), READ | WRITE),
        (request(77, 1, 2, 3), ALL_RIGHTS),
        (request(Command.READ_WRITE), READ | WRITE),
        (request(Command.READ), READ),
    ],
)
def test_what_a_request_needs(frame: Frame, needed: Right) -> None:
    assert needed_rights(frame) == needed


@given(st.integers(0, 20), st.binary(max_size=80), st.sampled_from([851, 500, 10_000]))
def test_each_request_needs_something(command: int, data: bytes, port: int) -> None:
    assert needed_rights(request(command, port=port, data=data))


def test_names() -> None:
    assert rights_named(["read", "files"]) == READ | FILES
    assert rights_named([]) == NO_RIGHTS
    with pytest.raises(ValueError, match=r"read, write, state, files, methods, got 'Read'"):
        rights_named(["Read"])
