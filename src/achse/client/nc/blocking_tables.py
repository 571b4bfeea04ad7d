"""Tables of an NC without asyncio: the names of `achse.client.nc.tables`, and they wait."""

from achse.ams import AdsError
from achse.client.nc import tables
from achse.client.nc.tables import TableFacts, TableKind
from achse.client.wrapper import Wrapper, blocking

_SHOWN_ROWS = 20_000


def _is_shown(known: TableFacts) -> bool:
    """True if a notebook draws it."""
    return known.kind is not TableKind.MOTION_FUNCTION and known.rows <= _SHOWN_ROWS


class RemoteTable(Wrapper[tables.RemoteTable]):
    """A table of an NC; see `achse.client.nc.RemoteTable`, whose methods these are."""

    @property
    def id(self) -> int:
        return self._inner.id

    def _repr_html_(self) -> str:
        """Return the table for a notebook, a cam with its curve; or the reason without."""
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

    facts = blocking(tables.RemoteTable.facts)
    slave_type = blocking(tables.RemoteTable.slave_type)
    create = blocking(tables.RemoteTable.create)
    delete = blocking(tables.RemoteTable.delete)
    check = blocking(tables.RemoteTable.check)
    read_rows = blocking(tables.RemoteTable.read_rows)
    write_rows = blocking(tables.RemoteTable.write_rows)
    read_points = blocking(tables.RemoteTable.read_points)
    write_points = blocking(tables.RemoteTable.write_points)
    change_when = blocking(tables.RemoteTable.change_when)
    values = blocking(tables.RemoteTable.values)
    demands = blocking(tables.RemoteTable.demands)
