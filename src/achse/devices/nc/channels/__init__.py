"""Channels, 0x2000 … 0x2300 + ID: the standard one, which has the PTP groups, and configured ones.

Rows of an interpreter answer 0x703 where a channel has none. Source: 002 §6.4.2.

Read `states` and `parameters` first, then `functions` and the `cyclic` interface. `every` has the
rows of all channels, `structures` what is packed, `binding` how a row finds its channel.
"""

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.channels.cyclic import PROGRAM_CYCLIC
from achse.devices.nc.channels.every import (
    EVERY_CYCLIC,
    EVERY_FUNCTION,
    EVERY_PARAMETER,
    EVERY_STATE,
)
from achse.devices.nc.channels.functions import PROGRAM_FUNCTIONS
from achse.devices.nc.channels.parameters import PROGRAM_PARAMETERS
from achse.devices.nc.channels.states import PROGRAM_STATES
from achse.motion import Nc
from achse.motion.channels.channel import NcChannel
from achse.server import IndexGroup, ObjectGroup

__all__ = ["CHANNEL_GROUPS", "OF_INTERPRETERS", "channel_groups"]

_HIGHEST_ID = 255

CHANNEL_GROUPS = (
    (0x2000, (*EVERY_PARAMETER, *PROGRAM_PARAMETERS)),
    (0x2100, (*EVERY_STATE, *PROGRAM_STATES)),
    (0x2200, (*EVERY_FUNCTION, *PROGRAM_FUNCTIONS)),
    (0x2300, (*EVERY_CYCLIC, *PROGRAM_CYCLIC)),
)
"""Index group + id, rows."""

OF_INTERPRETERS = (*PROGRAM_PARAMETERS, *PROGRAM_STATES, *PROGRAM_FUNCTIONS, *PROGRAM_CYCLIC)
"""Rows that only channels with an interpreter answer."""


def channel_groups(nc: Nc) -> list[IndexGroup]:
    """Return the index groups of channels; an id that no channel has is 0x4010."""

    def find(id: int) -> NcChannel:
        try:
            return nc.channels.channel(id)
        except KeyError:
            raise DeviceError(NcError.CHANNEL_ID.number, f"id {id}") from None

    return [ObjectGroup(base, _HIGHEST_ID, find, rows) for base, rows in CHANNEL_GROUPS]
