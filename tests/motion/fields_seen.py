"""Fields of all axes as arrays, cycle by cycle, on either kernel."""

from collections.abc import Callable
from typing import Any

import numpy as np

from achse.motion import Nc
from achse.motion.record import LAYOUT, PART_OF

__all__ = ["view"]


def view(nc: Nc, seen: tuple[str, ...], states: tuple[str, ...]) -> Callable[[], tuple[Any, Any]]:
    """Return a function that reads the fields `seen` (floats) and `states` (ints) of all axes."""
    if not nc.compiled:
        return lambda: (
            np.array([[getattr(axis, name) for name in seen] for axis in nc]),
            np.array([[getattr(axis, name) for name in states] for axis in nc]),
        )
    first: Any = nc.axis(1)
    floats = np.frombuffer(first._memory).reshape(len(nc), LAYOUT.words)
    ints = floats.view(np.int64)
    return lambda: (_columns(nc, floats, seen), _columns(nc, ints, states))


def _columns(nc: Nc, words: Any, names: tuple[str, ...]) -> Any:
    """These fields of all axes: from memory, those of the encoder one by one."""
    result = words[:, [PART_OF[name][1].offset for name in names]]
    for column, name in enumerate(names):
        if PART_OF[name][0]:
            result[:, column] = [getattr(axis, name) for axis in nc]
    return result
