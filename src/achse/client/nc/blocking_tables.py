"""Tables of an NC without asyncio: the names of `achse.client.nc.tables`, and they wait."""

from collections.abc import Sequence

from achse.ams import AdsError
from achse.client.loop import LoopThread
from achse.client.nc import tables
from achse.client.nc.tables import FunctionPoint, TableFacts, TableKind, TableValues

__all__ = ["RemoteTable"]

_SHOWN_ROWS = 20_000


def _is_shown(known: TableFacts) -> bool:
    """Whether a notebook draws it."""
    return known.kind is not TableKind.MOTION_FUNCTION and known.rows <= _SHOWN_ROWS


class RemoteTable:
    """A table of an NC; see `achse.client.nc.RemoteTable`, whose methods these are."""

    def __init__(self, loop: LoopThread, inner: tables.RemoteTable) -> None:
        self._loop = loop
        self._inner = inner

    def __repr__(self) -> str:
        return repr(self._inner)

    @property
    def id(self) -> int:
        return self._inner.id

    def _repr_html_(self) -> str:
        """What a notebook shows: what it is, and a cam as a curve; or why not."""
        from achse.plot import cam
        from achse.plot.markup import drawn, facts, picture

        try:
            known = self.facts()
            rows = self.read_rows() if _is_shown(known) else []
        except (AdsError, RuntimeError) as refusal:  # the latter of a client that is closed
            return facts(f"table {self.id}", [("not read", refusal)])
        named = ("kind", known.kind.name), ("cyclic", known.cyclic), ("rows", known.rows)
        text = facts(f"table {self.id} {known.name}", named)
        png = drawn(lambda: cam(rows))
        return text if png is None else picture(png, "slave over master position") + text

    def facts(self) -> TableFacts:
        """Name, kind and size."""
        return self._loop.run(self._inner.facts())

    def slave_type(self) -> int:
        """The slave type that follows such a table."""
        return self._loop.run(self._inner.slave_type())

    def create(
        self, rows: int, *, kind: TableKind = TableKind.CAM, cyclic: bool = False, columns: int = 2
    ) -> None:
        """Make the table, all 0."""
        self._loop.run(self._inner.create(rows, kind=kind, cyclic=cyclic, columns=columns))

    def delete(self) -> None:
        """Forget the table."""
        self._loop.run(self._inner.delete())

    def check(self) -> None:
        """See whether its numbers are a function."""
        self._loop.run(self._inner.check())

    def read_rows(self) -> list[tuple[float, ...]]:
        """All rows of a cam or a characteristic."""
        return self._loop.run(self._inner.read_rows())

    def write_rows(self, rows: Sequence[Sequence[float]], first: int = 0) -> None:
        """Write whole rows of a cam or a characteristic."""
        self._loop.run(self._inner.write_rows(rows, first))

    def read_points(self) -> list[FunctionPoint]:
        """All points of a motion function."""
        return self._loop.run(self._inner.read_points())

    def write_points(self, points: Sequence[FunctionPoint], first: int = 0) -> None:
        """Write points of a motion function."""
        self._loop.run(self._inner.write_points(points, first))

    def change_when(
        self, activation: int, position: float = 0.0, *, keep_place: bool = False
    ) -> None:
        """When written points become active."""
        self._loop.run(self._inner.change_when(activation, position, keep_place=keep_place))

    def values(self, master: float) -> TableValues:
        """Slave position, velocity and acceleration at a master position."""
        return self._loop.run(self._inner.values(master))

    def demands(self, master_velocity: float = 1.0) -> tuple[float, ...]:
        """The characteristic values at a master velocity."""
        return self._loop.run(self._inner.demands(master_velocity))
