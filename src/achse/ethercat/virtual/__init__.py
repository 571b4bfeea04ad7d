"""Virtual slaves made from ESI files: EEPROM, objects, process data, mailbox, behaviour.

`make_slave` makes a slave from a device that `EsiFolder` finds by name. Its inputs are set, and its
outputs read, by the names in the file; a `SlaveBehaviour` may do that in each local cycle.
"""

from achse.ethercat.virtual.behaviour import LoopBack, RecordedSignals, SlaveBehaviour
from achse.ethercat.virtual.device import VirtualDevice
from achse.ethercat.virtual.esi_folder import EsiFolder
from achse.ethercat.virtual.slaves import VirtualSlave, make_slave

__all__ = [
    "EsiFolder",
    "LoopBack",
    "RecordedSignals",
    "SlaveBehaviour",
    "VirtualDevice",
    "VirtualSlave",
    "make_slave",
]
