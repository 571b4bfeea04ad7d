"""The kernel of axes on drives; that it does what frames do is tested beside the shortcut."""

import pytest

from achse.motion.compiled import KERNEL as MOTION
from achse.native.backend import compiler_installed
from achse.station.buses.whole_cycle import KERNEL, STRAND


def test_it_knows_all_records_of_the_nc() -> None:
    assert MOTION.layouts.items() <= KERNEL.layouts.items()
    assert set(STRAND.fields) == {"record", "inputs", "outputs"}


@pytest.mark.skipif(not compiler_installed(), reason="needs llvmlite")
def test_it_can_be_compiled() -> None:
    assert KERNEL.available
    assert callable(KERNEL.function)
