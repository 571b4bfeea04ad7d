"""Requests that concern resources: what they change, and those that cannot."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Command
from achse.codes.ports import SYSTEM_PORT
from achse.router.forwarding.resource_requests import (
    change_of,
    handle_places,
    holds_nothing,
    is_always_decoded,
    without,
)
from tests.router.forwarding.test_ledger import FILE, PLC, SYSTEM, read_write, request


@given(
    st.sampled_from(
        (0xF003, 0xF004, 0xF080, 0xF081, 0xF082, 0xF085, 0xF086, 120, 121, 133, 0x4020)
    ),
    st.integers(0, 3),
    st.lists(st.sampled_from((0xF003, 0xF006, 0x4020, 4)), max_size=12),
)
def test_requests_that_hold_nothing_have_no_change(
    group: int, parts: int, words: list[int]
) -> None:
    frame = read_write(group, parts, struct.pack(f"<{len(words)}I", *words))
    if holds_nothing(group, frame.data, 0, len(frame.data)):
        assert change_of(frame) is None


@pytest.mark.parametrize("group", [0xF004, 0xF009, 0xF080, 0xF084, 0x4020])
def test_other_groups_change_nothing(group: int) -> None:
    assert change_of(read_write(group, 0, bytes(24))) is None
    assert change_of(request(Command.WRITE, struct.pack("<III", group, 0, 4) + bytes(4))) is None


def test_handles_are_taken_out_of_a_request_with_zero() -> None:
    frame = read_write(0xF086, 3, struct.pack("<III", 5, 6, 7))
    change = change_of(frame)
    assert change is not None
    data = without(frame.data, [change.actions[1]])
    assert struct.unpack_from("<III", data, 16) == (5, 0, 7)


@given(st.integers(0, 2**16 - 1), st.sampled_from((2, 3, 9)))
def test_requests_to_a_system_service_are_decoded_but_for_reads(port: int, command: int) -> None:
    target = PLC[:6] + port.to_bytes(2, "little")
    assert is_always_decoded(command, target) is (port == SYSTEM_PORT and command != Command.READ)


@given(st.sampled_from((111, 120, 121, 122, 133)), st.booleans())
def test_files_are_those_of_the_system_service(group: int, in_sum: bool) -> None:
    part = struct.pack("<IIII", group, 1, 4, 4)
    frame = read_write(0xF082, 1, part + b"name") if in_sum else read_write(group, 1, b"name")
    assert change_of(frame) is None
    frame.target = SYSTEM
    change = change_of(frame)
    assert (change is not None) is (group != 111 and group != 122)
    assert change is None or {each.kind for each in change.actions} == {FILE}


def test_request_by_a_symbol_handle_names_it_and_changes_nothing() -> None:
    frame = request(Command.READ, struct.pack("<III", 0xF005, 7, 4))
    [(_, position)] = handle_places(frame)
    assert (position, change_of(frame)) == (4, None)
