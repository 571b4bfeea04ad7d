"""pyads couples flying saws by the documented services, changes them, and lets them go."""

import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.interop.pyads_bench import MASTER, SLAVE, AxisBench

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

RUNS = 13


@pytest.fixture
def bench(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[AxisBench]:
    with AxisBench.enabled(pyads_connection(station, 501)) as bench:
        yield bench


def test_a_saw_couples_synchronises_changes_and_is_let_go(bench: AxisBench) -> None:
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
