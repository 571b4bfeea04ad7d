"""Table of all services of the NC by index group; rows are imported when needed (002 §6.4)."""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import NamedTuple

from achse.codes.nc.row import NcRow, by_name


class RowGroup(NamedTuple):
    """Place of the rows of an index group: module, name in it, clause of the manual."""

    module: str
    name: str
    clause: str


GROUPS = {
    0x1000: RowGroup("ring0", "RING0_PARAMETERS", "002 §6.4.1.1"),
    0x1100: RowGroup("ring0", "RING0_STATES", "002 §6.4.1.2"),
    0x1200: RowGroup("ring0", "RING0_FUNCTIONS", "002 §6.4.1.3"),
    0x2000: RowGroup("channels", "CHANNEL_PARAMETERS", "002 §6.4.2.1"),
    0x2100: RowGroup("channels", "CHANNEL_STATES", "002 §6.4.2.2"),
    0x2200: RowGroup("channels", "CHANNEL_FUNCTIONS", "002 §6.4.2.3"),
    0x2300: RowGroup("channels", "CHANNEL_CYCLIC", "002 §6.4.2.4"),
    0x3000: RowGroup("groups", "GROUP_PARAMETERS", "002 §6.4.3.1"),
    0x3100: RowGroup("groups", "GROUP_STATES", "002 §6.4.3.2"),
    0x3200: RowGroup("groups", "GROUP_FUNCTIONS", "002 §6.4.3.3"),
    0x4000: RowGroup("axis_parameters", "AXIS_PARAMETERS", "002 §6.4.4.1"),
    0x4100: RowGroup("axis_states", "AXIS_STATES", "002 §6.4.4.2"),
    0x4200: RowGroup("axis_functions", "AXIS_FUNCTIONS", "002 §6.4.4.3"),
    0x4300: RowGroup("axis_cyclic", "AXIS_CYCLIC", "002 §6.4.4.4"),
    0x5000: RowGroup("encoder", "ENCODER_PARAMETERS", "002 §6.4.5.1"),
    0x5100: RowGroup("encoder", "ENCODER_STATES", "002 §6.4.5.2"),
    0x5200: RowGroup("encoder", "ENCODER_FUNCTIONS", "002 §6.4.5.3"),
    0x5300: RowGroup("encoder", "ENCODER_CYCLIC", "002 §6.4.5.4"),
    0x6000: RowGroup("controller", "CONTROLLER_PARAMETERS", "002 §6.4.6.1"),
    0x6100: RowGroup("controller", "CONTROLLER_STATES", "002 §6.4.6.2"),
    0x7000: RowGroup("drive", "DRIVE_PARAMETERS", "002 §6.4.7.1"),
    0x7100: RowGroup("drive", "DRIVE_STATES", "002 §6.4.7.2"),
    0x7200: RowGroup("drive", "DRIVE_FUNCTIONS", "002 §6.4.7.3"),
    0x7300: RowGroup("drive", "DRIVE_CYCLIC", "002 §6.4.7.4"),
    0xA000: RowGroup("tables", "TABLE_PARAMETERS", "002 §6.4.8.1"),
    0xA100: RowGroup("tables", "TABLE_STATES", "002 §6.4.8.2"),
    0xA200: RowGroup("tables", "TABLE_FUNCTIONS", "002 §6.4.8.3"),
}
"""Index group, without the id that some add, and its rows."""


@cache
def rows_of(group: int) -> tuple[NcRow, ...]:
    """Rows of an index group. Raises KeyError for a group that the NC does not have."""
    place = GROUPS[group]
    rows: tuple[NcRow, ...] = getattr(
        import_module(f"achse.codes.nc.rows.{place.module}"), place.name
    )
    return rows


@cache
def named_rows(group: int) -> Mapping[str, NcRow]:
    """Rows of an index group by name. Raises KeyError for a group that the NC does not have."""
    return by_name(rows_of(group))


def every_row() -> Iterator[tuple[int, NcRow]]:
    """Yield every row behind its index group."""
    for group in GROUPS:
        for row in rows_of(group):
            yield group, row
