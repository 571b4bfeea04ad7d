"""Motion from Python: `axis = client.nc.axis("X")`, `await axis.move_to(300, velocity=200)`."""

from achse.client.nc.axis import Move, RemoteAxis
from achse.client.nc.controller import RemoteNc
from achse.client.nc.couplings import CouplingState
from achse.client.nc.errors import (
    AxisAborted,
    AxisDisabled,
    AxisError,
    AxisFailed,
    AxisRefused,
    AxisTimeout,
    UnknownAxis,
)
from achse.client.nc.parameters import AxisValue, AxisValues
from achse.client.nc.samples import AxisTrace
from achse.client.nc.services import UnknownService
from achse.client.nc.status import AxisStatus, PlcOpenState
from achse.client.nc.tables import FunctionPoint, RemoteTable, TableFacts, TableKind, TableValues

__all__ = [
    "AxisAborted",
    "AxisDisabled",
    "AxisError",
    "AxisFailed",
    "AxisRefused",
    "AxisStatus",
    "AxisTimeout",
    "AxisTrace",
    "AxisValue",
    "AxisValues",
    "CouplingState",
    "FunctionPoint",
    "Move",
    "PlcOpenState",
    "RemoteAxis",
    "RemoteNc",
    "RemoteTable",
    "TableFacts",
    "TableKind",
    "TableValues",
    "UnknownAxis",
    "UnknownService",
]
