"""FIFO groups over ADS."""

import struct
from typing import Any

import pytest

P, S, F = 0x300C, 0x310C, 0x320C


@pytest.fixture
def fifo(groups: Any) -> Any:
    groups.put(F, 0x52, "<2I", 1, 2)
    return groups


def rows(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


def test_a_client_fills_and_starts_a_fifo(fifo: Any, refused: Any) -> None:
    """The order of the manuals: assign, time delta, rows, override, start."""
    described = [fifo.get(P, offset, "<I") for offset in (0x03, 0x701, 0x702, 0x703, 0x704)]
    assert described == [11, 2, 250, 0, 1]
    fifo.put(P, 0x706, "<d", 0.01)
    with refused(0x4A1D):
        fifo.write(F, 0x701)
    fifo.write(F, 0x710, rows(0.0, 0.0, 1.0, 2.0))
    assert (fifo.get(S, 0x0C, "<I"), fifo.get(S, 0x0F, "<I")) == (2, 248)
    fifo.put(0x2302, 0x02, "<I", 500_000)
    fifo.write(F, 0x701)
    assert fifo.get(S, 0x05, "<I") == 2
    seen = []
    for _ in range(11):
        fifo.run(0.002)
        seen.append(round(fifo.axes(1)[0], 9))
    assert seen == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.0]
    assert fifo.axes(2) == [2.0]
    with refused(0x4220):
        fifo.write(F, 0x53)
    fifo.write(F, 0x02)
    fifo.run(0.004)
    fifo.write(F, 0x53)


def test_a_block_that_does_not_fit_is_refused_whole(fifo: Any, refused: Any) -> None:
    with refused(0x4A1E):
        fifo.write(F, 0x710, rows(*(0.0,) * 502))
    assert fifo.get(S, 0x0F, "<I") == 250
    with refused(0x42ED):
        fifo.write(F, 0x710, rows(1.0, 2.0, 3.0))
    with refused(0x705):
        fifo.write(F, 0x710, bytes(12))
    with refused(0x422C):
        fifo.write(F, 0x710, rows(float("nan"), 0.0))
    fifo.write(F, 0x710, rows(*(0.0,) * 500))
    assert fifo.get(S, 0x0F, "<I") == 0


@pytest.mark.parametrize(
    ("offset", "form", "values", "error"),
    [
        (0x704, "<I", (0, 3), 0x42EB),
        (0x705, "<d", (0.0, -1.0), 0x42EC),
        (0x706, "<d", (-0.001, float("inf")), 0x42EA),
    ],
)
def test_what_a_parameter_cannot_be(
    fifo: Any, refused: Any, offset: int, form: str, values: tuple[float, ...], error: int
) -> None:
    before = fifo.read(P, offset, 8)
    for value in values:
        with refused(error):
            fifo.put(P, offset, form, value)
    assert fifo.read(P, offset, 8) == before


def test_an_axis_that_is_not_at_the_first_row(fifo: Any, refused: Any) -> None:
    fifo.write(F, 0x710, rows(0.1, 0.0))
    with refused(0x4171):
        fifo.write(F, 0x701)
    fifo.write(F, 0x711, rows(0.0, 0.0, 0.5, 0.0))
    fifo.write(F, 0x701)


def test_an_axis_that_faults_stops_the_fifo(fifo: Any) -> None:
    fifo.write(F, 0x710, rows(*(x * 0.1 for n in range(200) for x in (n, n))))
    fifo.write(F, 0x701)
    fifo.run(0.5)
    fifo.put(0x4201, 0x19, "<I", 0x4650)
    fifo.until(lambda: not fifo.nc.groups.group(12).moving)
    assert fifo.get(S, 0x01, "<i") == 0x4650
    fifo.until(lambda: not any(axis.set_velocity for axis in fifo.nc))
    fifo.write(F, 0x01)
    fifo.run(0.01)
    assert fifo.get(S, 0x01, "<i") == fifo.axis.error_code == 0
