"""Edges, priorities, BUSY, ERR and ERRID of the TcNC blocks, call by call (004 §3.1)."""

import struct
from itertools import permutations
from typing import Any

import pytest

from achse.codes import NcError, ReturnCode

# The order of AXFNC (004 §3.1.1): input, edge, and what is sent.
ORDER = (
    ("SETDRIVE", False, 0x27),
    ("MANFW", False, 0x02),
    ("MANBW", False, 0x02),
    ("SETDRIVE", True, 0x26),
    ("MANFW", True, 0x20),
    ("MANBW", True, 0x20),
    ("RESET", True, 0x01),
    ("CALIBR", True, 0x10),
    ("SETPOS", True, 0x1A),
    ("SETTARG", True, 0x11),
)
PAIRS = [
    (first, second)
    for first, second in permutations(range(len(ORDER)), 2)
    if first < second and ORDER[first][0] != ORDER[second][0]
]


def _position(kind: int, value: float) -> bytes:
    return struct.pack("<IId", kind, 0, value)


def test_every_pair_of_edges_of_axfnc(bench: Any) -> None:
    """The one of higher rank is sent, alone; the other is forgotten."""
    assert len(PAIRS) == 42
    on = bench(f="AXFNC")
    on.set("f", AXID=9, MODE=1, VAL=1.5)  # nobody has this id: requests are seen, nothing moves
    for first, second in PAIRS:
        for name, _, _ in ORDER:
            on.set("f", **{name: False})
        on.call(3)
        for name, rises, _ in (ORDER[first], ORDER[second]):
            on.set("f", **{name: not rises})
            on.call(3)
        on.requests()
        for name, rises, _ in (ORDER[first], ORDER[second]):
            on.set("f", **{name: rises})
        on.call(4)
        sent = on.requests()
        assert [(group, offset) for _, group, offset, _ in sent] == [(0x4209, ORDER[first][2])]
        if ORDER[first][0] in ("MANFW", "MANBW") and ORDER[first][1]:
            kind = 3 if ORDER[first][0] == "MANFW" else 4
            assert sent[0][3] == struct.pack("<IIdd", kind, 0, 0.0, 1.5)


def test_busy_lasts_one_call_and_the_error_until_the_next_command(bench: Any) -> None:
    on = bench(f="AXFNC")
    on.set("f", AXID=77, RESET=True)
    seen = []
    for _ in range(3):
        on.call()
        seen.append(on.shown("f"))
    assert seen == [
        (True, False, 0),
        (False, True, NcError.AXIS_ID),
        (False, True, NcError.AXIS_ID),
    ]
    on.set("f", RESET=False, AXID=1)
    on.call(2)
    assert on.shown("f") == (False, True, NcError.AXIS_ID)
    on.set("f", RESET=True)
    on.call()
    assert on.shown("f") == (True, False, 0)
    on.call()
    assert on.shown("f") == (False, False, 0)


@pytest.mark.parametrize(
    ("block", "edge", "inputs"),
    [
        ("AXFNC", "RESET", {}),
        ("AXACT", "STOP", {}),
        ("AXACTEX", "STOP", {}),
        ("AXCPL", "CPLOFF", {}),
        ("AXCPLTAB", "CPLOFF", {}),
        ("AXSCOM", "COMP_OFF", {}),
    ],
)
def test_no_answer_is_0x745_after_the_time_out(
    bench: Any, block: str, edge: str, inputs: dict[str, Any]
) -> None:
    from datetime import timedelta

    on = bench(b=block)
    on.station.router.deliver = lambda frame: True  # nobody answers any more
    timeout = {"TMOU" if block == "AXACT" else "TMOUT": timedelta(milliseconds=50)}
    on.set("b", AXID=1, **timeout, **{edge: True})
    on.call(5)
    assert on.shown("b") == (True, False, 0)
    on.call()
    assert on.shown("b") == (False, True, ReturnCode.CLIENT_TIMEOUT.number)
    on.set("b", **{edge: False}, **{key: timedelta(0) for key in timeout})
    on.call()
    on.set("b", **{edge: True})
    on.call(500)
    assert on.shown("b") == (True, False, 0)  # without a time-out: 5 s
    on.call()
    assert on.shown("b") == (False, True, ReturnCode.CLIENT_TIMEOUT.number)


def test_edges_while_busy_are_lost(bench: Any) -> None:
    on = bench(f="AXFNC")
    on.station.router.deliver = lambda frame: True
    on.set("f", AXID=1, RESET=True)
    on.call()
    on.set("f", MANFW=True, VAL=10.0)
    on.call(600)
    assert on.shown("f")[1]
    on.set("f", MANFW=False)
    on.call()
    assert on.shown("f")[0]  # its falling edge counts again


@pytest.mark.parametrize(
    ("block", "stop", "start", "offset"),
    [
        ("AXACT", "STOP", "START", 0x02),
        ("AXACTEX", "STOP", "START", 0x02),
        ("AXCPL", "CPLOFF", "CPLON", 0x41),
        ("AXCPLTAB", "CPLOFF", "CPLON", 0x41),
        ("AXSCOM", "COMP_OFF", "COMP_ON", 0x31),
    ],
)
def test_what_ends_beats_what_begins(
    bench: Any, block: str, stop: str, start: str, offset: int
) -> None:
    on = bench(b=block)
    on.set("b", AXID=1, **{stop: True, start: True})
    on.call(5)
    assert on.requests() == [(500, 0x4201, offset, b"")]
    on.set("b", **{stop: False})
    on.call(3)
    assert on.requests() == []


def test_an_input_that_is_true_from_the_first_call_on_is_an_edge(bench: Any) -> None:
    on = bench(calls="first(AXID := 1, RESET := TRUE);", variables="first : AXFNC;")
    assert on.requests() == [(500, 0x4201, 0x01, b"")]


@pytest.mark.parametrize("axis", [-1, 256, 0x100 + 1, -32768, 32767, 0])
def test_ids_that_no_axis_has_reach_no_other_place(bench: Any, axis: int) -> None:
    on = bench(f="AXFNC")
    on.set("f", AXID=axis, RESET=True)
    on.call(2)
    assert on.requests() == [(500, 0x4200, 0x01, b"")]
    assert on.shown("f") == (False, True, NcError.AXIS_ID)
