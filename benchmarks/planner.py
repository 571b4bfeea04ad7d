"""Cost of one profile plan: ours interpreted, ours compiled, ruckig; same cases, one run.

    python benchmarks/planner.py [--cases N]

Compiled plans run in a compiled loop, as in the NC cycle; ruckig is called through its Python
binding, once with the inputs set for each case and once with `calculate` alone.
"""

import argparse
import contextlib
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from ruckig import InputParameter, Ruckig, RuckigError, Trajectory

from achse.motion.profiles import profile
from achse.motion.profiles.segments import MAX_SEGMENTS
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out


class Case:
    """One situation, and the segments planned for it."""

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    target: float = 0.0
    end_velocity: float = 0.0
    top: float = 0.0
    acc: float = 0.0
    dec: float = 0.0
    jerk: float = 0.0
    times: list[float] = [0.0] * MAX_SEGMENTS
    jerks: list[float] = [0.0] * MAX_SEGMENTS


CASE = lay_out("case", [Case], Slot)


def plan_all(cases: Sequence[Case]) -> None:
    """Plan each case."""
    for i in range(len(cases)):
        c = cases[i]
        p, v, a, target, end = c.position, c.velocity, c.acceleration, c.target, c.end_velocity
        profile.plan_to_position(
            c.times, c.jerks, p, v, a, target, end, c.top, c.acc, c.dec, c.jerk
        )


def situations(kind: str, count: int) -> np.ndarray:
    """Rows (p, v, a, target, end velocity, top, acc, dec, jerk) in mm."""
    rng = np.random.default_rng(1)
    top = 10.0 ** rng.uniform(1.0, 3.5, count)
    acc = top * 10.0 ** rng.uniform(0.0, 1.5, count)
    dec = acc if kind != "any state, dec != acc" else acc * 10.0 ** rng.uniform(-0.5, 0.5, count)
    jerk = acc * 10.0 ** rng.uniform(0.0, 2.0, count)
    moving = 0.0 if kind == "rest to rest" else 1.0
    v = moving * top * rng.uniform(-1.0, 1.0, count)
    a = moving * np.minimum(acc, np.sqrt(jerk * top)) * rng.uniform(-1.0, 1.0, count)
    target = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-3.0, 4.0, count)
    nothing = np.zeros(count)
    return np.stack([nothing, v, a, target, nothing, top, acc, dec, jerk], axis=1)


def per_call(run: Callable[[], object], count: int, repeat: int = 5) -> float:
    """Best of `repeat` runs in microseconds per case."""
    best = float("inf")
    for _ in range(repeat):
        start = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - start)
    return best / count * 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=20_000)
    count = parser.parse_args().cases
    fast = Kernel("planner", plan_all, {Case: CASE}).function

    otg, request, trajectory = Ruckig(1), InputParameter(1), Trajectory(1)
    request.target_velocity = [0.0]
    request.target_acceleration = [0.0]

    print(f"{'µs per plan':<24}{'compiled':>10}{'Python':>10}{'ruckig':>10}{'+ inputs':>10}")
    for kind in ("rest to rest", "any state", "any state, dec != acc"):
        cases = situations(kind, count)
        rows = cases.tolist()
        memory = np.zeros((count, CASE.words))
        memory[:, : cases.shape[1]] = cases
        t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS

        def interpreted(
            rows: list[list[float]] = rows, t: list[float] = t, j: list[float] = j
        ) -> None:
            for row in rows:
                profile.plan_to_position(t, j, *row)

        def oracle(calculate: bool, rows: list[list[float]] = rows) -> None:
            for p, v, a, target, _, top, acc, dec, jerk in rows:
                request.current_position = [p]
                request.current_velocity = [v]
                request.current_acceleration = [a]
                request.target_position = [target]
                request.max_velocity = [top]
                request.max_acceleration = [acc]
                request.min_acceleration = [-dec]
                request.max_jerk = [jerk]
                if calculate:
                    with contextlib.suppress(RuckigError):  # it gives up on some
                        otg.calculate(request, trajectory)

        compiled = per_call(partial(fast, memory.ctypes.data, count), count)
        plain = per_call(interpreted, count)
        whole = per_call(partial(oracle, True), count)
        inputs = per_call(partial(oracle, False), count)
        print(f"{kind:<24}{compiled:>10.3f}{plain:>10.2f}{whole - inputs:>10.2f}{whole:>10.2f}")
    print(f"{count} cases; ruckig needs acceleration limits by sign, ours by direction of travel")


if __name__ == "__main__":
    main()
