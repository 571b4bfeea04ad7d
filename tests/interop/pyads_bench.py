"""Two axes as pyads reaches them, for what couples one to the other."""

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Self

import pytest

from tests.interop.waiting import until

__all__ = ["MASTER", "SLAVE", "AxisBench"]

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

MASTER, SLAVE = 1, 2
STATE, FUNCTION, CYCLIC = 0x4100, 0x4200, 0x4300


class AxisBench:
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

    @classmethod
    @contextmanager
    def enabled(cls, nc: Any) -> Iterator[Self]:
        """A bench whose axes are enabled meanwhile."""
        bench = cls(nc)
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
