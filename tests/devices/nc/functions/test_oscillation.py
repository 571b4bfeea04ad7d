"""Oscillations over ADS: both forms reach the axis, mistakes are refused."""

from math import pi
from typing import Any

import pytest

F, STATES = 0x4201, 0x4101

FORMS = pytest.mark.parametrize("gap", ["", "4x"], ids=["TwinCAT 2", "TwinCAT 3"])


@FORMS
def test_reversing(bench: Any, gap: str) -> None:
    bench.put(F, 0x25, f"<I{gap}dddd", 1, 20.0, -10.0, 100.0, 0.2)
    targets = []
    for _ in range(3):
        bench.until(lambda: bench.axis.set_motion_phase == 6)
        targets.append(bench.get(STATES, 0x0A, "<d"))
        bench.until(lambda: bench.axis.set_motion_phase != 6)
    assert targets == [20.0, -10.0, 20.0]
    bench.write(F, 0x02, b"")
    bench.until_rest()


@pytest.mark.parametrize("form", ["<IddddI", "<I4xddddI4x"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_velocity_steps(bench: Any, form: str) -> None:
    bench.put(F, 0x32, form, 1, 40.0, -10.0, 0.1, 0.05, 2)
    assert bench.until_rest() == pytest.approx(2 * (0.1 + 0.05) * 2, abs=0.003)
    assert bench.get(STATES, 0x0A, "<d") == pytest.approx(2 * (40.0 - 10.0) * 0.1)


@FORMS
def test_sine(bench: Any, gap: str) -> None:
    sine = (1, 10.0, 1.953125, 0.0, 10.0, 20.0, 100.0, 0.512, 2, 1)
    bench.put(F, 0x33, f"<I{gap}dddddddII", *sine)
    highest = 0.0
    while bench.axis.set_motion_phase:
        highest = max(highest, bench.get(STATES, 0x0A, "<d"))
        bench.run(0.002)
    assert highest == pytest.approx(10.0 / (pi * 1.953125), rel=1e-3)


def test_mistakes(bench: Any, refused: Any) -> None:
    with refused(0x4295):
        bench.put(F, 0x25, "<Idddd", 1, 20.0, 20.0, 100.0, 0.2)
    with refused(0x4221):
        bench.put(F, 0x32, "<IddddI", 1, 4000.0, -10.0, 0.1, 0.05, 2)
    with refused(0x423B):
        bench.put(F, 0x33, "<IdddddddII", 1, 10.0, 11.0, 0.0, 10.0, 20.0, 100.0, 0.5, 2, 1)
