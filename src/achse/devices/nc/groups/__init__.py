"""Groups, 0x3000 … 0x3200 + ID: parameters, states, functions, a file for each kind of group.

Each axis has a PTP group of its own, which has the axis' id; groups of several axes are configured.
A row of another kind of group answers 0x703. Source: 002 §6.4.3.

Read `every` first: rows of all groups. `single` is the PTP group of an axis; `path`, `kinematic`
and `fifo` are groups of several axes, `places` the axes in them. `binding` is how a row finds its
group.
"""

from achse.devices.nc.groups.every import EVERY_FUNCTION, EVERY_PARAMETER, EVERY_STATE
from achse.devices.nc.groups.fifo import FIFO_FUNCTIONS, FIFO_PARAMETERS
from achse.devices.nc.groups.kinematic import (
    KINEMATIC_FUNCTIONS,
    KINEMATIC_PARAMETERS,
    KINEMATIC_STATES,
)
from achse.devices.nc.groups.path import PATH_PARAMETERS, PATH_STATES
from achse.devices.nc.groups.places import PLACE_FUNCTIONS, PLACE_STATES
from achse.devices.nc.groups.single import SINGLE_FUNCTIONS, SINGLE_PARAMETERS

__all__ = ["GROUP_FUNCTIONS", "GROUP_PARAMETERS", "GROUP_STATES", "OF_ONE_KIND"]

GROUP_PARAMETERS = (
    *EVERY_PARAMETER,
    *SINGLE_PARAMETERS,
    *PATH_PARAMETERS,
    *FIFO_PARAMETERS,
    *KINEMATIC_PARAMETERS,
)

GROUP_STATES = (*EVERY_STATE, *PLACE_STATES, *PATH_STATES, *KINEMATIC_STATES)

GROUP_FUNCTIONS = (
    *EVERY_FUNCTION,
    *SINGLE_FUNCTIONS,
    *PLACE_FUNCTIONS,
    *FIFO_FUNCTIONS,
    *KINEMATIC_FUNCTIONS,
)

OF_ONE_KIND = tuple(
    row
    for rows in (GROUP_PARAMETERS, GROUP_STATES, GROUP_FUNCTIONS)
    for row in rows
    if row not in (*EVERY_PARAMETER, *EVERY_STATE, *EVERY_FUNCTION)
)
"""Rows that not every group answers."""
