"""pyads fills a table by the documented services, couples by it, follows, and deletes it."""

import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

MASTER, SLAVE = 1, 2
STATE, FUNCTION, CYCLIC = 0x4100, 0x4200, 0x4300
TABLE, USERS, MAKE = 0xA000 + 77, 0xA100 + 77, 0xA200 + 77
ROWS, SINGLE = 0x0100_0000, 0x20


class TableBench:
    """Axis 1 and axis 2 as pyads reaches them: numbers from the manual, nothing of ours."""

    def __init__(self, nc: Any) -> None:
        self._nc = nc

    def call(self, axis: int, offset: int, data: bytes = b"") -> None:
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self._nc.write(FUNCTION + axis, offset, list(data), kind)

    def get(self, axis: int, offset: int, form: str) -> tuple[Any, ...]:
        size = struct.calcsize(form)
        return struct.unpack(
            form, bytes(self._nc.read(STATE + axis, offset, pyads.PLCTYPE_BYTE * size))
        )

    def places(self) -> tuple[float, float]:
        """Set positions of master and slave."""
        return self.get(MASTER, 0x0A, "<d")[0], self.get(SLAVE, 0x0A, "<d")[0]

    def write(self, group: int, offset: int, data: bytes = b"") -> None:
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self._nc.write(group, offset, list(data), kind)

    def users(self) -> int:
        return int(self._nc.read(USERS, 0x0A, pyads.PLCTYPE_DINT))

    def rows(self, size: int) -> bytes:
        return bytes(self._nc.read(TABLE, ROWS, pyads.PLCTYPE_BYTE * size))

    def until(self, condition: Callable[[], object]) -> None:
        until(condition)

    def enable(self, axis: int, bits: int) -> None:
        self._nc.write(CYCLIC + axis, 0x01, bits, pyads.PLCTYPE_UDINT)
        self._nc.write(CYCLIC + axis, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)

    def is_enabled(self, axis: int) -> bool:
        return bool(self._nc.read(CYCLIC + axis, 0x81, pyads.PLCTYPE_UDINT) & 1)

    def at_rest(self) -> bool:
        return all(self.get(axis, 0x0E, "<d") == (0.0,) for axis in (MASTER, SLAVE))


@pytest.fixture
def bench(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[TableBench]:
    bench = TableBench(pyads_connection(station, 501))
    for axis in (MASTER, SLAVE):
        bench.call(axis, 0x01)
        bench.enable(axis, 0b111)
        bench.until(lambda axis=axis: bench.is_enabled(axis))  # type: ignore[misc]
    yield bench
    for axis in (MASTER, SLAVE):
        bench.call(axis, 0x02)
    bench.until(bench.at_rest)
    for axis in (MASTER, SLAVE):
        bench.enable(axis, 0)


def test_a_table_is_filled_followed_changed_and_deleted(bench: TableBench) -> None:
    begin, slave = bench.places()
    bench.write(MAKE, 0x10000, struct.pack("<3I", 4, 3, 2))
    numbers = struct.pack("<6d", 0.0, 0.0, 30.0, 10.0, 60.0, 0.0)
    bench.write(TABLE, ROWS, numbers)
    bench.write(TABLE, SINGLE, struct.pack("<IId", 1, 1, 12.0))
    assert struct.unpack("<6d", bench.rows(48)) == (0.0, 0.0, 30.0, 12.0, 60.0, 0.0)
    solo = (10, MASTER, 0, 0, 77, 0, 0.0, 0.0, 1.0, 1.0, 0, 0, 0, 0.0, 0, 0)
    bench.call(SLAVE, 0x4A, struct.pack("<6I4d3I4xd2I", *solo))
    assert (bench.get(SLAVE, 0x20, "<I"), bench.get(SLAVE, 0x21, "<I")) == ((3,), (77,))
    assert bench.users() == 1
    with pytest.raises(pyads.ADSError) as refused:
        bench.write(MAKE, 0x20000)
    assert refused.value.err_code == 0x4259
    for way, height in ((15.0, 6.0), (30.0, 12.0), (75.0, 6.0)):
        bench.call(MASTER, 0x20, struct.pack("<IIdd", 1, 0, begin + way, 50.0))
        bench.until(lambda way=way: bench.places()[0] == begin + way)  # type: ignore[misc]
        assert bench.places()[1] == pytest.approx(slave + height, abs=1e-9)
    scaling = (0, 0.0, 2, 1, 0.0, 0.0, 1.0, 2.0)
    bench.call(SLAVE, 0x4D, struct.pack("<I4xd2I4d", *scaling))
    bench.call(MASTER, 0x20, struct.pack("<IIdd", 1, 0, begin + 90.0, 50.0))
    bench.until(lambda: bench.places()[0] == begin + 90.0)
    assert bench.places()[1] == pytest.approx(slave + 18.0, abs=1e-9)
    bench.call(SLAVE, 0x41)
    assert bench.users() == 0
    bench.write(MAKE, 0x20000)
    with pytest.raises(pyads.ADSError):
        bench.rows(48)
