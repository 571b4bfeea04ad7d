"""Ruckig as the oracle: where it and we solve the same problem, ours takes no longer.

The problem is the same while the axis keeps its direction: ruckig limits acceleration by sign, we
by direction of travel, so each case is mirrored to travel forward. A reversal is another problem,
because ours passes rest (v = 0 with a = 0) by rule: those cases are solved, but not timed here.
Two more differences are the oracle's: it accepts an end up to 1e-8 mm off the target, which is
granted as the time that distance is worth; and above the velocity limit it first brakes by a fixed
rule, which may take longer than ours.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from ruckig import InputParameter, Result, Ruckig, RuckigError, Trajectory

from achse.motion.profiles.profile import plan_to_position, stopping_distance
from achse.motion.profiles.segments import (
    MAX_SEGMENTS,
    duration,
    segment_acceleration,
    segment_position,
    segment_velocity,
)

CASES = 30_000
ORACLE_POSITION_ERROR = 1e-8  # mm


def generate(seed: Any, count: Any) -> Any:
    """Rows (p, v, a, target, top, acc, dec, jerk) in mm and s, three in four travelling forward."""
    rng = np.random.default_rng(seed)

    def decades(low: Any, high: Any) -> Any:
        return 10.0 ** rng.uniform(low, high, count)

    def sometimes(share: Any, value: Any) -> Any:
        return np.where(rng.random(count) < share, value, 0.0)

    top = decades(-1, 3.5)
    acc = top * decades(-1, 2)
    dec = np.where(rng.random(count) < 0.5, acc, acc * decades(-1, 1))
    jerk = acc * decades(-1, 2.5)
    way = rng.choice([-1.0, 1.0], count)
    fast = np.where(rng.random(count) < 0.1, 1.5, 1.0)
    v = way * sometimes(0.8, rng.uniform(0.0, 1.0, count) * top * fast)
    # what a jerk-limited move at this velocity may have: it can still be released before v = 0
    a = np.minimum(dec, np.sqrt(2.0 * jerk * np.abs(v))) * rng.uniform(-1.0, 0.0, count)
    a = np.where(rng.random(count) < 0.5, a, np.minimum(acc, np.sqrt(jerk * top)))
    a = way * sometimes(0.7, a * rng.uniform(0.0, 1.0, count))
    p = sometimes(0.5, rng.uniform(-1000.0, 1000.0, count))
    rows = np.stack([p, v, a, p, top, acc, dec, jerk], axis=1).tolist()
    share = rng.random(count)
    beyond = decades(-6, 5).tolist()
    closeness = np.abs(rng.normal(size=count)) * decades(-6, 0.7)
    share, closeness, way = share.tolist(), closeness.tolist(), way.tolist()
    for i, row in enumerate(rows):
        stop = stopping_distance(row[1], row[2], row[6], row[7])
        if share[i] < 0.4:  # ahead, near the shortest distance the brakes allow
            row[3] = row[0] + stop * (1.0 + closeness[i])
        elif share[i] < 0.75:  # ahead, any distance beyond
            row[3] = row[0] + stop + way[i] * beyond[i]
        else:  # anywhere
            row[3] = row[0] + beyond[i] * (1.0 if share[i] < 0.875 else -1.0)
    return rows


def test_no_longer_than_ruckig_wherever_the_direction_is_kept(many: Callable[[int], int]) -> None:
    cases = many(CASES)
    otg, values, trajectory = Ruckig(1), InputParameter(1), Trajectory(1)
    values.target_velocity = [0.0]
    values.target_acceleration = [0.0]
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    reversals = refused = shorter = too_fast = 0
    ratios = []
    slower = []
    for p, v, a, target, top, acc, dec, jerk in generate(1, cases):
        n = plan_to_position(t, j, p, v, a, target, 0.0, top, acc, dec, jerk)
        assert n >= 0, (p, v, a, target, top, acc, dec, jerk)
        lowest = highest = w = v
        x, b = p, a
        reach = max(1.0, abs(p), abs(target))
        for i in range(n):
            x, w, b = (
                segment_position(t[i], j[i], x, w, b),
                segment_velocity(t[i], j[i], w, b),
                segment_acceleration(t[i], j[i], b),
            )
            lowest = min(lowest, w)
            highest = max(highest, w)
            reach = max(reach, abs(x))
        assert abs(x - target) <= 1e-12 * reach, (p, v, a, target, top, acc, dec, jerk)
        if lowest < -1e-9 * highest and highest > -1e-9 * lowest:
            reversals += 1
            continue
        way = 1.0 if highest > -lowest else -1.0
        values.current_position = [way * p]
        values.current_velocity = [way * v]
        values.current_acceleration = [way * a]
        values.target_position = [way * target]
        values.max_velocity = [top]
        values.max_acceleration = [acc]
        values.min_acceleration = [-dec]
        values.max_jerk = [jerk]
        try:
            result = otg.calculate(values, trajectory)
        except RuckigError:
            refused += 1
            continue
        if result not in (Result.Working, Result.Finished):
            refused += 1
            continue
        ours, theirs = duration(t, n), trajectory.duration
        if theirs > 0.0:
            ratios.append(ours / theirs)
            if ours < theirs * (1.0 - 1e-6) - 1e-9:
                shorter += 1
                too_fast += max(abs(v), abs(v + a * abs(a) / (2.0 * jerk))) > top
        if ours > theirs * (1.0 + 1e-6) + 1e-9:
            slower.append((ours, theirs, (p, v, a, target, top, acc, dec, jerk)))
    # Granted: the time that the oracle's position error is worth, at most that of a move from rest.
    unexplained = [
        entry
        for entry in slower
        if entry[0] - entry[1] > 4.0 * math.cbrt(ORACLE_POSITION_ERROR / (2.0 * entry[2][7]))
    ]
    quantiles = np.quantile(ratios, [0.0, 0.01, 0.5, 0.99, 1.0])
    print(f"{cases} cases: {reversals} reversals not timed, ruckig refused {refused}")
    print("ours / ruckig: min, 1 %, median, 99 %, max:", *(f"{q:.9f}" for q in quantiles))
    print(f"shorter than ruckig: {shorter}, of them from above the velocity limit: {too_fast}")
    print(f"longer than ruckig: {len(slower)}, beyond its position error: {len(unexplained)}")
    assert not unexplained, unexplained[:3]
    assert len(slower) <= cases // 10_000, slower[:3]
    assert len(ratios) > cases // 2
