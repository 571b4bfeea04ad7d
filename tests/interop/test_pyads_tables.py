"""pyads fills a table by the documented services, couples by it, follows, and deletes it."""

import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.interop.pyads_bench import MASTER, SLAVE, AxisBench

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

TABLE, USERS, MAKE = 0xA000 + 77, 0xA100 + 77, 0xA200 + 77
ROWS, SINGLE = 0x0100_0000, 0x20


class TableBench(AxisBench):
    """With a table and those who use it."""

    def write(self, group: int, offset: int, data: bytes = b"") -> None:
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self._nc.write(group, offset, list(data), kind)

    def users(self) -> int:
        return int(self._nc.read(USERS, 0x0A, pyads.PLCTYPE_DINT))

    def rows(self, size: int) -> bytes:
        return bytes(self._nc.read(TABLE, ROWS, pyads.PLCTYPE_BYTE * size))


@pytest.fixture
def bench(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[TableBench]:
    with TableBench.enabled(pyads_connection(station, 501)) as bench:
        yield bench


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
