"""Blocks of a part program per second: read, and interpreted, on one core.

The program is what a CAM system writes: short lines with a number, two or three coordinates, now
and then an arc, a feed or a comment. Beside it: the same text only cut by one expression, its
numbers made floats, as the bare minimum. Usage: python benchmarks/gcode_parse.py [BLOCKS]
"""

import re
import sys
import time
from collections.abc import Callable
from math import cos, sin

from achse.gcode.interpretation.interpreter import Interpreter
from achse.gcode.text.blocks import parse_block
from achse.gcode.text.program import PartProgram

CUT = re.compile(r"([A-Z])([-+]?[\d.]+)")


def program(blocks: int) -> str:
    """Lines along a spiral."""
    lines = ["N1 G90 G17 F10000"]
    for n in range(2, blocks + 1):
        x, y = n * 0.001 * cos(n * 0.01), n * 0.001 * sin(n * 0.01)
        if n % 50 == 0:
            lines.append(f"N{n} G2 X{x:.4f} Y{y:.4f} B{n:.1f} (ARC)")
        elif n % 50 == 1:
            lines.append(f"N{n} G1 X{x:.4f} Y{y:.4f} Z{n % 7:.3f} F{6000 + n % 100}")
        else:
            lines.append(f"N{n} X{x:.4f} Y{y:.4f}")
    return "\n".join(lines)


def best(run: Callable[[], object]) -> float:
    """Seconds of the quickest of three runs."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    blocks = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    text = program(blocks)
    lines = text.split("\n")

    def bare() -> None:
        for line in lines:
            [(letter, float(number)) for letter, number in CUT.findall(line)]

    def parse() -> None:
        for line in lines:
            parse_block(line)

    def interpret() -> None:
        count = sum(1 for _ in Interpreter(PartProgram(text)))
        assert count == blocks, count

    for name, run in (("bare", bare), ("parse", parse), ("interpret", interpret)):
        seconds = best(run)
        each = seconds / blocks * 1e6
        print(f"{name:10}{blocks / seconds:12,.0f} blocks/s{each:9.2f} µs per block")


if __name__ == "__main__":
    main()
