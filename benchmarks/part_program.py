"""A part program of very short blocks, run by a channel on the axes of an NC: does it keep up?

    python benchmarks/part_program.py [blocks] [--cycle-us 1000] [--compiled auto|yes|no]

Blocks of 5 µm on a curve in space, 10 m/min programmed, look-ahead of 128 blocks. All of the way
is measured: text, interpreter, feeder, look-ahead, group, three axes with their drives. The axes
are quick ones (10 g), for the path must be able to stop within the 0.64 mm that it knows ahead,
less what it goes in a cycle. Beside it, in the same run: the interpreter alone, and the same text
only cut into numbers, as the bare minimum. Times are those of the processor.
"""

import argparse
import gc
import re
import tempfile
import time
from math import cos, dist, sin
from pathlib import Path

from achse.gcode.interpretation.interpreter import Interpreter
from achse.gcode.text.program import PartProgram
from achse.motion import AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.channels.store import ProgramStore
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import GroupType
from achse.motion.path import PathLine

LENGTH = 0.005
FEED = 10_000.0
AXIS = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 1_000.0,
    "default_acceleration": 100_000.0,
    "default_deceleration": 100_000.0,
    "max_acceleration": 100_000.0,
    "max_deceleration": 100_000.0,
    "default_jerk": 1e8,
    "simulation_ideal": 1.0,
}
CUT = re.compile(r"([A-Z])([-+]?[\d.]+)")


def program(blocks: int) -> tuple[str, tuple[float, float, float]]:
    """Lines on a curve with bends down to a few mm, to a tenth of a micrometre; and its end."""
    lines = [f"G90 G17 G1 F{FEED:g}", "#set paramC1ReductionFactor(1)#"]
    x = y = z = 0.0
    for n in range(blocks):
        way = LENGTH * n
        heading = 3.0 * sin(way / 17.0) + sin(way / 5.0)
        slope = 0.3 * sin(way / 11.0)
        x += LENGTH * cos(heading) * cos(slope)
        y += LENGTH * sin(heading) * cos(slope)
        z += LENGTH * sin(slope)
        lines.append(f"N{n + 1} X{x:.5f} Y{y:.5f} Z{z:.5f}")
    lines.append("M30")
    return "\n".join(lines), (round(x, 5), round(y, 5), round(z, 5))


def make(folder: Path, cycle_us: int, compiled: bool | None) -> Nc:
    """Three axes in the 3D group of a channel."""
    return Nc(
        cycle_us * 1000,
        [AxisParameters(n, name, values=AXIS) for n, name in enumerate("XYZ", 1)],
        groups=[GroupParameters(11, GroupType.THREE_D, 1, axes=(1, 2, 3), segments_per_cycle=128)],
        channels=[ChannelParameters(1, store=ProgramStore(folder))],
        compiled=compiled,
    )


def long_line(cycle_us: int, compiled: bool | None, cycles: int = 1000) -> tuple[float, float]:
    """µs per cycle: of the axes alone, and with their group on one long line."""
    nc = make(Path("."), cycle_us, compiled)
    group = nc.groups.group(11)
    assert isinstance(group, PathGroup)
    times = []
    for leading in (False, True):
        if leading:
            group.begin()
            group.append(PathLine((1000.0, 500.0, 300.0), 100.0))
        nc.cycle(5)
        begin = time.thread_time()
        for _ in range(cycles):
            nc.cycle()
        times.append((time.thread_time() - begin) / cycles * 1e6)
    return times[0], times[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blocks", type=int, nargs="?", default=100_000)
    parser.add_argument("--cycle-us", type=int, default=1000)
    parser.add_argument("--compiled", choices=("auto", "yes", "no"), default="auto")
    arguments = parser.parse_args()
    blocks, cycle = arguments.blocks, arguments.cycle_us
    text, end = program(blocks)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "curve.nc").write_text(text)
        compiled = {"auto": None, "yes": True, "no": False}[arguments.compiled]
        nc = make(folder, cycle, compiled)
        channel, group = nc.channels.channel(1), nc.groups.group(11)
        assert isinstance(channel, ProgramChannel)
        assert isinstance(group, PathGroup)
        group.reduction_method = 1  # cosine: these corners are no corners
        group.critical_angle_low = 5.0
        nc.cycle(5)
        gc.collect()
        gc.freeze()  # as `achse run` does
        begin = time.thread_time()
        code = channel.load("curve.nc")
        loaded = time.thread_time() - begin
        assert code == 0, hex(code)
        code = channel.start()
        assert code == 0, hex(code)
        cycles = late = 0
        spent = slowest = fastest = 0.0
        while channel.state is not InterpreterState.READY:
            begin = time.thread_time()
            nc.cycle()
            took = time.thread_time() - begin
            spent += took
            slowest = max(slowest, took)
            late += took > cycle * 1e-6
            cycles += 1
            fastest = max(fastest, group.view.velocity)
            assert channel.error_code == 0, hex(channel.error_code)
    here = [axis.set_position for axis in nc]
    assert dist(here, end) < 1e-9, (here, end)
    motion = cycles * cycle * 1e-6
    begin = time.thread_time()
    for line in text.split("\n"):
        [(letter, float(number)) for letter, number in CUT.findall(line)]
    bare = time.thread_time() - begin
    begin = time.thread_time()
    for _ in Interpreter(PartProgram(text)):
        pass
    interpreted = time.thread_time() - begin
    print(
        f"{blocks:,} blocks of 5 µm: {motion:.2f} s of motion in {spent:.2f} s;"
        f" up to {fastest * 0.06:.2f} m/min; loaded in {loaded:.3f} s"
    )
    alone, leading = long_line(cycle, compiled)
    print(f"whole way   {spent / blocks * 1e6:8.2f} µs per block")
    print(f"interpreter {interpreted / blocks * 1e6:8.2f} µs per block")
    print(f"bare cut    {bare / blocks * 1e6:8.2f} µs per block")
    print(f"three axes at rest {alone:.1f} µs per cycle, on a long line {leading:.1f} µs")
    print(f"slowest cycle {slowest * 1e3:.3f} ms, {late} of {cycles} beyond {cycle / 1000:g} ms")


if __name__ == "__main__":
    main()
