"""Users of tables: an axis with its drives, and as a slave with its cams.

What uses a table follows from the records of the axes alone, so a slave that the cycle lets go has
let its tables go too.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Protocol

from achse.motion.states import CAM_COUPLINGS


# Any: records have their fields by name in either form
class TableUser(Protocol):
    """An axis: its drives have characteristics, as a slave it has cams."""

    axis_id: int
    resting: int
    coupling: Any
    camming: Any
    loop_closed: int
    position_range_window: float

    def wake(self, *, adapts: bool = False) -> None:
        """Go on with the next cycle, and compute there what follows from the parameters."""

    def show_cams(self) -> None:
        """Show its cams and what waits for them after a change of a table, and wake."""

    @property
    def rows(self) -> Any:
        """Rows of the kernel; `cams` of it are the numbers of all tables."""

    @property
    def drives(self) -> Sequence[Any]:
        """Each has `table_id` and `table_interpolation_type`, its valve `amplifier.table_id`."""

    @property
    def cams(self) -> Sequence[Any]:
        """Layers: `table`, `interpolation`, and `next_table` … of what is to come; 0: none."""


def cams_in_use(axes: Iterable[TableUser]) -> Iterator[tuple[TableUser, int, int]]:
    """Table and interpolation of each layer of each slave, and of what it will change to."""
    for axis in axes:
        if axis.coupling.law in CAM_COUPLINGS:
            for layer in axis.cams[: axis.camming.count]:
                if layer.now.table:
                    yield axis, layer.now.table, layer.now.interpolation
                if layer.next.table:
                    yield axis, layer.next.table, layer.next.interpolation


# Any: a guard reads the set point and the limits of the axes too
def at_work(axes: Iterable[TableUser], key: tuple[int, int]) -> list[Any]:
    """Return the slaves that move by this table and interpolation."""
    return [
        axis
        for axis in axes
        if axis.coupling.law in CAM_COUPLINGS
        and axis.loop_closed
        and any(
            (layer.now.table, layer.now.interpolation) == key
            for layer in axis.cams[: axis.camming.count]
        )
    ]
