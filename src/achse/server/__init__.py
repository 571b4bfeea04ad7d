"""The ADS device framework: service rows, symbols, sum commands and notifications behind a port.

A device is a `Device` with groups of rows over its state; see `rows` for what a row says.
"""

from achse.server.budget import SampleBudget
from achse.server.device import DIRECT_CODES_OF_A_PLC, Device, DeviceRouter
from achse.server.limits import ClientLimits
from achse.server.rows import (
    BYTES,
    READ,
    READ_WRITE,
    VOID,
    WRITE,
    Access,
    Codec,
    Layout,
    Repeated,
    RowFacts,
    Service,
)
from achse.server.symbols import ResolvedSymbol, SymbolSource, TableSizes
from achse.server.table import AreaGroup, Group, IndexGroup, ObjectGroup, RawGroup, ServiceTable
from achse.server.usage import Usage

__all__ = [
    "BYTES",
    "DIRECT_CODES_OF_A_PLC",
    "READ",
    "READ_WRITE",
    "VOID",
    "WRITE",
    "Access",
    "AreaGroup",
    "ClientLimits",
    "Codec",
    "Device",
    "DeviceRouter",
    "Group",
    "IndexGroup",
    "Layout",
    "ObjectGroup",
    "RawGroup",
    "Repeated",
    "ResolvedSymbol",
    "RowFacts",
    "SampleBudget",
    "Service",
    "ServiceTable",
    "SymbolSource",
    "TableSizes",
    "Usage",
]
