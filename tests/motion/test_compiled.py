"""The kernel in machine code; that it computes the same is tested beside the kernel."""

import subprocess
import sys

from achse.motion.compiled import KERNEL
from achse.motion.control import curves
from achse.motion.machine.record import AMPLIFIER, MACHINE, SENSOR
from achse.motion.record import ENCODER, LAYOUT
from achse.native.memory import Rows


def test_no_axes_are_no_work() -> None:
    layouts = LAYOUT, ENCODER, LAYOUT, curves.LAYOUT, LAYOUT, MACHINE, SENSOR, AMPLIFIER
    rows = [Rows(layout, 0) for layout in layouts]
    KERNEL.function(*(part for each in rows for part in (each.address, 0)), 0.002, 3)


def test_motion_needs_no_compiler() -> None:
    script = (
        "import sys; sys.modules['llvmlite'] = None\n"
        "from achse.motion import AxisParameters, Nc, commands\n"
        "nc = Nc(2_000_000, [AxisParameters(1)]); nc.cycle(); print(len(nc.digest()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "16\n"
