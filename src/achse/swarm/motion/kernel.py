"""The watch of one NC: `look` and all checks for each axis, as they are or as machine code.

Kernel source, in the language of `achse.native`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from achse.motion import Nc
from achse.motion.compiled import KERNEL as MOTION
from achse.motion.kernel import cycles
from achse.motion.machine.kernel import HardwareRows
from achse.motion.rows import NcRows
from achse.native.compiled import Kernel
from achse.native.memory import Rows, structure_of
from achse.swarm.motion.checks import CHECKS
from achse.swarm.motion.step import STEP, MotionStep, look

ACTIVE = 1
"""WrongSetPoint on axes of which one moves or waits; 0: all rest."""

_FIRST = 2
_CHECK_COUNT = len(CHECKS)


@dataclass
class StepRows:
    """Steps of all axes; machine code gets address and number."""

    steps: Sequence[MotionStep]


@dataclass(frozen=True)
class WrongSetPoint:
    """A set point that is wrong: row of its axis, number of the check in `CHECKS`."""

    axis: int
    check: int

    @classmethod
    def of(cls, number: int) -> "WrongSetPoint | None":
        """Return the verdict with this number, None if all holds."""
        return None if number < _FIRST else cls(*divmod(number - _FIRST, _CHECK_COUNT))


def watch(rows: NcRows, hardware: HardwareRows, dt: float, watched: StepRows, checked: int) -> int:
    """Look at all axes after a cycle; return 0, `ACTIVE` or the number of a verdict.

    `checked` has a bit for each check of `CHECKS` that is made.
    """
    active = 0
    coupled = 0
    for i in range(len(watched.steps)):
        step = watched.steps[i]
        look(step, rows.axes[i], rows)
        active |= step.active
        coupled |= step.coupled
    if coupled:
        _smooth_as_masters(rows, watched)
    for i in range(len(watched.steps)):
        step = watched.steps[i]
        if step.phase != 0 or step.v1 != 0.0 or step.v0 != 0.0 or step.p1 != step.p0:
            if step.smooth == 0:
                step.abrupt_cycles += 1
            number = -1
            for check in CHECKS:
                number += 1
                if (checked >> number) & 1 and check(step):
                    return _FIRST + i * _CHECK_COUNT + number
    return active


def _smooth_as_masters(rows: NcRows, watched: StepRows) -> None:
    """Mark a slave as smooth as its masters, which come first in the order of the cycle."""
    for i in range(len(watched.steps)):
        watched.steps[i].bumpy = 0
        watched.steps[i].pulled_jerk = 0.0
        watched.steps[i].hidden = 0.0
    for n in range(len(rows.order)):
        step = watched.steps[rows.order[n]]
        if step.law and step.smooth:
            master = watched.steps[step.first_master]
            jumps = master.coupled != 0 and (master.law != 1 or master.gear != master.gear0)
            step.bumpy = int(jumps or master.bumpy != 0)
            rests = master.phase == 0 and master.phase0 == 0 and master.v0 == 0.0
            step.smooth = int(master.smooth != 0 or rests)
            mean = 0.5 * (master.v0 + master.v1) * master.dt
            step.hidden = step.ratio * (abs(master.p1 - master.p0 - mean) + master.hidden)
            if step.law == 1:
                step.pulled_jerk = abs(step.gear) * max(master.jerk, master.pulled_jerk)


def cycles_under_watch(
    rows: NcRows,
    hardware: HardwareRows,
    dt: float,
    watched: StepRows,
    checked: int,
    count: int,
) -> int:
    """Do `count` cycles, each under watch, until a set point is wrong.

    Return the cycles that were done, times 65,536, and the last verdict.
    """
    verdict = 0
    done = 0
    while done < count:
        cycles(rows, hardware, dt, 1)
        done += 1
        verdict = watch(rows, hardware, dt, watched, checked)
        if verdict > ACTIVE:
            break
    return done * 65536 + verdict


_LAYOUTS = {**MOTION.layouts, MotionStep: STEP}

WATCH = Kernel("swarm-watch", watch, _LAYOUTS)
CYCLES = Kernel("swarm-cycles", cycles_under_watch, _LAYOUTS)


class AxesUnderWatch:
    """The axes of an NC and what is seen of them."""

    def __init__(self, nc: Nc, checked: int) -> None:
        self._nc = nc
        self._checked = checked
        count = len(nc)
        self.steps: list[Any]
        self._arguments: tuple[Any, ...] = ()
        self._calls: dict[str, Callable[..., int]] = {}
        if nc.compiled:
            self._rows = Rows(STEP, count)
            self.steps = [structure_of(STEP).from_buffer(self._rows.row(n)) for n in range(count)]
        else:
            self.steps = [STEP.plain() for _ in range(count)]

    @property
    def moves(self) -> int:
        """Commands that axes took."""
        return sum(each.moves for each in self.steps)

    @property
    def abrupt_cycles(self) -> int:
        """Cycles of an axis in which the manuals are abrupt."""
        return sum(each.abrupt_cycles for each in self.steps)

    @cached_property
    def _watched(self) -> StepRows:
        return StepRows(self.steps)

    def look(self) -> int:
        """Look at all axes after a cycle, see `watch`."""
        return self._bound("look", WATCH, self._checked)()

    def cycle(self, count: int) -> tuple[int, int]:
        """Do cycles under watch, see `cycles_under_watch`: how many were done, and the verdict."""
        done, verdict = divmod(self._bound("cycle", CYCLES, self._checked)(count), 65536)
        self._nc.cycle_count += done
        return done, verdict

    def _bound(self, name: str, kernel: Kernel, *last: int) -> Callable[..., int]:
        arguments = self._nc.kernel_arguments
        if arguments is not self._arguments:
            self._arguments = arguments
            self._calls.clear()
        call = self._calls.get(name)
        if call is None:
            if self._nc.compiled:
                call = kernel.bind(*arguments, self._rows.address, self._rows.count, *last)
            else:
                call = partial(kernel.plain, *arguments, self._watched, *last)
            self._calls[name] = call
        return call
