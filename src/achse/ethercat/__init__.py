"""EtherCAT: frames, slave controllers with what sits behind them, and segments of slaves.

A frame goes through `Segment.process`; each `Slave` is a slave controller (`Esc`) with an
`Application` behind it. Nothing here opens a socket or reads a clock.
"""

from achse.codes import DataType
from achse.ethercat.application import (
    Application,
    Identity,
    ObjectAccess,
    ObjectCode,
    ObjectDescription,
    ObjectEntry,
)
from achse.ethercat.description import SlaveDescription, describe
from achse.ethercat.esc import Esc
from achse.ethercat.frame import Datagram, DatagramCommand, EthercatFrame, FrameError
from achse.ethercat.loopback import Loopback
from achse.ethercat.pdi import AlEvent, Pdi, PdiAccess
from achse.ethercat.segment import Disturbance, Segment
from achse.ethercat.sii import build_sii
from achse.ethercat.slave import Slave

__all__ = [
    "AlEvent",
    "Application",
    "DataType",
    "Datagram",
    "DatagramCommand",
    "Disturbance",
    "Esc",
    "EthercatFrame",
    "FrameError",
    "Identity",
    "Loopback",
    "ObjectAccess",
    "ObjectCode",
    "ObjectDescription",
    "ObjectEntry",
    "Pdi",
    "PdiAccess",
    "Segment",
    "Slave",
    "SlaveDescription",
    "build_sii",
    "describe",
]
