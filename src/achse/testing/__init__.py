"""Tools for tests with achse: a station in a fixture, fakes, clocks and conformance checks.

With achse installed, every pytest run has the fixture `achse_station`; see `plugin`. Names are
loaded when they are first used: the plugin costs a test run nothing until a test asks for it.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from achse.drive import VirtualDrive as VirtualDrive
    from achse.testing.addresses import free_host as free_host
    from achse.testing.axis_conformance import AxisReach as AxisReach
    from achse.testing.axis_conformance import check_axis as check_axis
    from achse.testing.bench import PlcUnit as PlcUnit
    from achse.testing.bench import PlcUnitFault as PlcUnitFault
    from achse.testing.bench import plc_unit as plc_unit
    from achse.testing.clock import ManualClock as ManualClock
    from achse.testing.clock import VirtualTimeLoop as VirtualTimeLoop
    from achse.testing.conformance import ConformanceError as ConformanceError
    from achse.testing.conformance import check_device as check_device
    from achse.testing.conformance import check_transport as check_transport
    from achse.testing.device import FakeDevice as FakeDevice
    from achse.testing.drive_conformance import check_drive as check_drive
    from achse.testing.live import Live as Live
    from achse.testing.live import LiveStation as LiveStation
    from achse.testing.pair import LinkedPair as LinkedPair
    from achse.testing.pair import LinkEnd as LinkEnd
    from achse.testing.reach import DriveReach as DriveReach
    from achse.testing.reach import PysoemReach as PysoemReach
    from achse.testing.reach import ReachError as ReachError
    from achse.testing.reach import SegmentReach as SegmentReach

__all__ = [
    "AxisReach",
    "ConformanceError",
    "DriveReach",
    "FakeDevice",
    "LinkEnd",
    "LinkedPair",
    "Live",
    "LiveStation",
    "ManualClock",
    "PlcUnit",
    "PlcUnitFault",
    "PysoemReach",
    "ReachError",
    "SegmentReach",
    "VirtualDrive",
    "VirtualTimeLoop",
    "check_axis",
    "check_device",
    "check_drive",
    "check_transport",
    "free_host",
    "plc_unit",
]

_HOMES = {
    "AxisReach": "achse.testing.axis_conformance",
    "ConformanceError": "achse.testing.conformance",
    "DriveReach": "achse.testing.reach",
    "FakeDevice": "achse.testing.device",
    "LinkEnd": "achse.testing.pair",
    "LinkedPair": "achse.testing.pair",
    "Live": "achse.testing.live",
    "LiveStation": "achse.testing.live",
    "ManualClock": "achse.testing.clock",
    "PlcUnit": "achse.testing.bench",
    "PlcUnitFault": "achse.testing.bench",
    "PysoemReach": "achse.testing.reach",
    "ReachError": "achse.testing.reach",
    "SegmentReach": "achse.testing.reach",
    "VirtualDrive": "achse.drive",
    "VirtualTimeLoop": "achse.testing.clock",
    "check_axis": "achse.testing.axis_conformance",
    "check_device": "achse.testing.conformance",
    "check_drive": "achse.testing.drive_conformance",
    "check_transport": "achse.testing.conformance",
    "free_host": "achse.testing.addresses",
    "plc_unit": "achse.testing.bench",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_HOMES[name]), name)
    return value
