"""The order of a cycle: masters have their turns before the axes that follow them.

So a chain of any length has no lag. Axes without a master keep the order of their ids as far as
that goes; the order depends on the couplings, not on the time of coupling.

Who follows whom is said by the records of the axes alone. An order that was made for a coupling is
right without it too, so letting an axis go needs no new one.
"""

from array import array
from collections.abc import Iterable, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter


class CouplingRing(ValueError):
    """An axis would follow itself, by way of others or not; `rows` is the ring."""

    def __init__(self, rows: Iterable[int]) -> None:
        self.rows = tuple(rows)
        super().__init__(f"axes in a ring: rows {' → '.join(map(str, self.rows))}")


class CycleOrder:
    """Order of the axes of `count` rows in a cycle.

    `rows` is memory that plain and compiled kernels read, and stays where it is.
    """

    def __init__(self, count: int) -> None:
        self.rows = array("q", range(count))

    @property
    def arguments(self) -> tuple[int, int]:
        """Address and number, as machine code takes a row of numbers."""
        return self.rows.buffer_info()

    def arrange(self, masters: Mapping[int, Sequence[int]]) -> None:
        """Order masters before their slaves from the next cycle on; `masters` has the rows that a
        row follows.

        Raises CouplingRing, and then the order is as before.
        """
        sorter = TopologicalSorter({row: masters.get(row, ()) for row in range(len(self.rows))})
        try:
            sorter.prepare()
        except CycleError as error:
            raise CouplingRing(error.args[1]) from None
        order: list[int] = []
        while sorter.is_active():
            ready = sorted(sorter.get_ready())
            order += ready
            sorter.done(*ready)
        self.rows[:] = array("q", order)
