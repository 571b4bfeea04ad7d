"""pyads couples flying saws by the documented services, changes them, and lets them go."""

import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

MASTER, SLAVE = 1, 2
STATE, FUNCTION, CYCLIC = 0x4100, 0x4200, 0x4300
RUNS = 13


class SawBench:
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
def bench(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[SawBench]:
    bench = SawBench(pyads_connection(station, 501))
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


def test_a_saw_couples_synchronises_changes_and_is_let_go(bench: SawBench) -> None:
    begin, slave = bench.places()
    saw = (6, MASTER, 0, 0, 1.0, begin + 60.0, slave - 30.0, 0, 0, 0, 0, 0)
    with pytest.raises(pyads.ADSError) as refused:
        bench.call(SLAVE, 0x4B, struct.pack("<4I7dI4x", *saw))
    assert refused.value.err_code == 0x42DF
    saw = (6, MASTER, 0, 0, 1.0, begin + 60.0, slave + 30.0, 0, 0, 0, 0, 0)
    bench.call(SLAVE, 0x4B, struct.pack("<4I7dI4x", *saw))
    assert bench.get(SLAVE, 0x20, "<I") == (3,)
    assert bench.get(SLAVE, 0x26, "<64d")[6:9] == pytest.approx((begin + 60.0, slave + 30.0, 1.0))
    bench.call(MASTER, 0x20, struct.pack("<IIdd", 1, 0, begin + 100.0, 50.0))
    bench.until(lambda: bench.places()[0] == begin + 100.0)
    assert bench.places()[1] == pytest.approx(slave + 70.0, abs=1e-9)
    bench.call(SLAVE, 0x42, struct.pack("<4d", 0.5, 0.0, 0.0, 0.0))
    bench.call(MASTER, 0x20, struct.pack("<IIdd", 1, 0, begin + 120.0, 50.0))
    bench.until(lambda: bench.places()[0] == begin + 120.0)
    assert bench.places()[1] == pytest.approx(slave + 80.0, abs=1e-9)
    bench.call(MASTER, 0x20, struct.pack("<IIdd", 1, 0, begin, 50.0))
    bench.until(lambda: bench.get(SLAVE, 0x0E, "<d")[0] < -24.0)
    bench.call(SLAVE, 0x44)
    bench.until(bench.at_rest)
    assert bench.get(SLAVE, 0x20, "<I") == (0,)
    assert bench.get(SLAVE, 0x01, "<I") == (0,)
    with pytest.raises(pyads.ADSError):
        bench.call(SLAVE, 0x44)
