"""The EtherCAT master, sans-I/O: configuration, start-up, process data, mailbox, clocks, diagnosis.

`Master(BusConfiguration(...))` gives frames to send and takes those that came; `Ring` joins it to a
segment in the same process.
"""

from achse.ethercat.master.bus_slave import BusSlave
from achse.ethercat.master.configuration import (
    BusConfiguration,
    ClockConfiguration,
    InitCommand,
    SlaveConfiguration,
    StateTimes,
    from_description,
    from_sii,
)
from achse.ethercat.master.errors import BusError, SdoRefusal, StateRefusal
from achse.ethercat.master.events import BusEvent, BusEventKind, EmergencyMessage
from achse.ethercat.master.master import Master
from achse.ethercat.master.ring import Ring
from achse.ethercat.master.traffic import BusJob

__all__ = [
    "BusConfiguration",
    "BusError",
    "BusEvent",
    "BusEventKind",
    "BusJob",
    "BusSlave",
    "ClockConfiguration",
    "EmergencyMessage",
    "InitCommand",
    "Master",
    "Ring",
    "SdoRefusal",
    "SlaveConfiguration",
    "StateRefusal",
    "StateTimes",
    "from_description",
    "from_sii",
]
