"""Checks before a change of state: mailbox, process data, SYNC0, seen by a master."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState

I, P, S, O = AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP  # noqa: E741
ERROR, ACKNOWLEDGE = 0x10, 0x10


def sync_manager(start: int, length: int, control: int, enable: int = 1) -> bytes:
    return (
        start.to_bytes(2, "little") + length.to_bytes(2, "little") + bytes((control, 0, enable, 0))
    )


@pytest.mark.parametrize(
    ("out", "into"),
    [
        (sync_manager(0x1000, 256, 0x26, 0), sync_manager(0x1100, 256, 0x22)),
        (sync_manager(0x1000, 256, 0x26), sync_manager(0x1100, 256, 0x22, 0)),
        (sync_manager(0x1010, 240, 0x26), sync_manager(0x1100, 256, 0x22)),
        (sync_manager(0x1000, 257, 0x26), sync_manager(0x1101, 256, 0x22)),
        (sync_manager(0x1000, 33, 0x26), sync_manager(0x1100, 256, 0x22)),
        (sync_manager(0x1000, 256, 0x22), sync_manager(0x1100, 256, 0x22)),
        (sync_manager(0x1000, 256, 0x26), sync_manager(0x1100, 256, 0x26)),
        (sync_manager(0x1000, 256, 0x24), sync_manager(0x1100, 256, 0x22)),
        (bytes(8), bytes(8)),
    ],
)
def test_a_wrong_mailbox_is_refused(master: Any, out: bytes, into: bytes) -> None:
    master.write(0x0800, out + into)
    assert master.request(P) == (I | ERROR, 0x0016)


def test_a_shorter_mailbox_will_do(master: Any) -> None:
    master.write(0x0800, sync_manager(0x1000, 64, 0x26) + sync_manager(0x1100, 64, 0x22))
    assert master.request(P) == (P, 0)


@pytest.mark.parametrize(
    ("outputs", "inputs", "code"),
    [
        (sync_manager(0x1200, 5, 0x64), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x1200, 4, 0x64, 0), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x1200, 4, 0x20), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x1200, 4, 0x66), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x0F80, 4, 0x64), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x2FFC, 4, 0x64), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x10FE, 4, 0x64), sync_manager(0x1300, 4, 0x20), 0x001D),
        (sync_manager(0x1200, 4, 0x64), sync_manager(0x1300, 3, 0x20), 0x001E),
        (sync_manager(0x1200, 4, 0x64), sync_manager(0x1300, 4, 0x64), 0x001E),
        (sync_manager(0x1200, 4, 0x64), bytes(8), 0x001E),
        (sync_manager(0x1300, 4, 0x64), sync_manager(0x1302, 4, 0x20), 0x001D),
    ],
)
def test_wrong_process_data_is_refused(
    line: Callable[..., Any], outputs: bytes, inputs: bytes, code: int
) -> None:
    master = line(1)
    master.bring(P)
    master.write(0x0810, outputs + inputs)
    assert master.request(S) == (P | ERROR, code)
    master.process_data()
    assert master.request(S | ACKNOWLEDGE) == (S, 0)


def test_masters_may_place_process_data_anywhere_in_memory(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(P)
    master.write(0x0810, sync_manager(0x1800, 4, 0x24) + sync_manager(0x1C00, 4, 0x20))
    assert master.request(S) == (S, 0)


def _sync0(master: Any, cycle_ns: int, start_ns: int) -> None:
    master.write(0x09A0, cycle_ns.to_bytes(4, "little"))
    master.write(0x0990, start_ns.to_bytes(8, "little"))
    master.write(0x0980, b"\x00\x03")


@pytest.mark.parametrize(("cycle_ns", "expected"), [(0, (P | ERROR, 0x0035)), (10**6, (S, 0))])
def test_sync0_that_is_switched_on_needs_a_cycle(
    line: Callable[..., Any], cycle_ns: int, expected: tuple[int, int]
) -> None:
    master = line(1)
    master.bring(P)
    master.process_data()
    _sync0(master, cycle_ns, 10**10)
    assert master.request(S) == expected


@pytest.mark.parametrize(("start_ns", "expected"), [(10**6, (S | ERROR, 0x001A)), (10**10, (O, 0))])
def test_op_is_refused_when_sync0_never_comes(
    line: Callable[..., Any], start_ns: int, expected: tuple[int, int]
) -> None:
    """A start time that is over is never met; one that lies ahead is waited for."""
    master = line(1)
    master.advance(5)
    master.bring(P)
    master.process_data()
    _sync0(master, 10**6, start_ns)
    assert master.request(S) == (S, 0)
    master.exchange(bytes(4))
    assert master.request(O) == expected
