"""A program of very short blocks: what planning costs, and whether it runs in real time.

    python benchmarks/path_blocks.py [blocks]

Blocks of 5 µm on a curve in space, 10 m/min programmed, cycles of 2 ms, look-ahead of 128 blocks.
Each cycle fills the table and goes on by one cycle, as the group of an NC does. Beside it, in the
same run, a bare numpy pass over the whole path: velocities within acceleration limits, without
jerk, look-ahead or set points. Times are those of the processor.
"""

import argparse
import time

import numpy as np

from achse.motion.path import PathLimits, PathParameters, PathPlanner, ReductionMethod

LENGTH = 0.005
FEED = 10_000.0 / 60.0
CYCLE = 0.002
ACCELERATION = 10_000.0
LIMITS = PathLimits(500.0, ACCELERATION, 5e6)


def points(blocks: int) -> np.ndarray:
    """A curve with bends down to a few mm, in steps of 5 µm."""
    way = LENGTH * np.arange(blocks + 1)
    heading = 3.0 * np.sin(way / 17.0) + np.sin(way / 5.0)
    slope = 0.3 * np.sin(way / 11.0)
    steps = np.stack(
        [np.cos(heading) * np.cos(slope), np.sin(heading) * np.cos(slope), np.sin(slope)], axis=1
    )
    return np.concatenate([np.zeros((1, 3)), np.cumsum(LENGTH * steps[:-1], axis=0)])


def bare(path: np.ndarray) -> float:
    """Duration by numpy: forward and backward pass of the squares of velocities; s."""
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    tangents = steps / lengths[:, None]
    turn = np.abs(np.diff(tangents, axis=0)).max(axis=1)
    most = np.full(len(path), FEED**2)
    most[0] = most[-1] = 0.0
    most[1:-1] = np.minimum(most[1:-1], ACCELERATION * LENGTH / np.maximum(turn, 1e-12))
    way = 2.0 * ACCELERATION * np.concatenate([[0.0], np.cumsum(lengths)])
    forward = np.minimum.accumulate(most - way) + way
    squares = np.minimum.accumulate((forward + way)[::-1])[::-1] - way
    velocities = np.sqrt(np.maximum(squares, 0.0))
    return float(np.sum(2.0 * lengths / np.maximum(velocities[1:] + velocities[:-1], 1e-9)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blocks", type=int, nargs="?", default=100_000)
    blocks = parser.parse_args().blocks
    curve = points(blocks)
    program = [tuple(point) for point in curve[1:].tolist()]
    parameters = PathParameters(
        method=ReductionMethod.COSINE, c0=0.1, angle_low=5.0, angle_high=90.0
    )
    path = PathPlanner(
        [LIMITS] * 3, (0.0, 0.0, 0.0), cycle_time=CYCLE, parameters=parameters, compiled=True
    )
    taken = cycles = starved = 0
    slowest = filling = moving = 0.0
    while True:
        begin = time.thread_time()
        if taken < blocks:
            taken += path.append_lines(program[taken : taken + path.free], FEED, taken)
        middle = time.thread_time()
        path.advance()
        end = time.thread_time()
        cycles += 1
        filling += middle - begin
        moving += end - middle
        slowest = max(slowest, end - begin)
        starved += end - begin > CYCLE
        if path.finished and taken == blocks:
            break
    begin = time.thread_time()
    least = bare(curve)
    numpy_time = time.thread_time() - begin
    duration = cycles * CYCLE
    print(f"{blocks:,} blocks of 5 µm: {duration:.3f} s of motion in {filling + moving:.3f} s")
    print(f"planning {(filling + moving) / blocks * 1e6:8.2f} µs per block")
    print(f"  appending {filling / blocks * 1e6:6.2f}, cycle {moving / blocks * 1e6:6.2f}")
    print(f"slowest cycle {slowest * 1e3:.3f} ms, {starved} of {cycles} beyond {CYCLE * 1e3:g} ms")
    print(f"bare numpy {numpy_time / blocks * 1e6:8.2f} µs per block, {least:.3f} s of motion")


if __name__ == "__main__":
    main()
