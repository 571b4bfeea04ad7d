"""Rows: what the kernel gets of an NC, in the order in which machine code takes it."""

from types import FunctionType

from achse.motion.compiled import KERNEL
from achse.motion.kernel import cycles
from achse.motion.machine.kernel import HardwareRows
from achse.motion.rows import NcRows
from achse.native.kernels.translate import ENTRY, interface_of


def test_each_row_is_an_address_and_a_number_for_machine_code() -> None:
    assert isinstance(cycles, FunctionType)
    entry = interface_of(cycles, KERNEL.layouts).functions[ENTRY]
    rows = len(NcRows.__annotations__) + len(HardwareRows.__annotations__)
    times = 2
    assert len(entry.signature.parameters) == 2 * rows + times
