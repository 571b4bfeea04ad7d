"""Setting positions over ADS."""

from math import nan
from typing import Any

import pytest

F = 0x4201


REAL, FLAG, NUMBER = "<d", "<H", "<I"


@pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=["TwinCAT 2", "TwinCAT 3"])
@pytest.mark.parametrize(
    ("kind", "position", "result"), [(1, -5.0, -5.0), (2, -5.0, 35.0), (5, 7.0, 7.0)]
)
def test_set_actual_position(
    bench: Any, form: str, kind: int, position: float, result: float
) -> None:
    bench.start(40.0, 100.0)
    bench.until_rest()
    bench.run(0.5)
    bench.put(F, 0x1A, form, kind, position)
    bench.run(0.01)
    assert bench.axis.actual_position == pytest.approx(result, abs=1e-3)
    assert bench.axis.set_position == pytest.approx(result, abs=1e-3)


def test_the_homed_flag(bench: Any, refused: Any) -> None:
    bench.put(F, 0x1B, NUMBER, 1)
    bench.run(0.002)
    assert bench.get(0x4301, 0x81, NUMBER) & 1 << 1
    with refused(0x4404):
        bench.put(F, 0x1B, NUMBER, 2)


def test_mistakes_of_set_actual_position(make_bench: Any, refused: Any) -> None:
    bench = make_bench()
    for kind, position, error in ((1, 1e12, 0x4422), (1, nan, 0x4422), (3, 1.0, 0x4250)):
        with refused(error):
            bench.put(F, 0x1A, "<I4xd", kind, position)
    bench.start(100.0, 100.0)
    with refused(0x4220):
        bench.put(F, 0x1A, "<I4xd", 1, 0.0)
    with refused(0x4257):
        make_bench(encoder_is_absolute=1).put(F, 0x1A, "<I4xd", 1, 0.0)


def test_only_the_standard_encoder_can_be_set(bench: Any, refused: Any) -> None:
    for offset in (0x0010_001A, 0x0080_001B):
        with refused(0x4012):
            bench.put(F, offset, "<I", 1) if offset & 1 else bench.put(F, offset, "<Id", 1, 0.0)
