"""Numbers with names, read by every other room: errors, states, index groups."""

from achse.codes.ads import ReturnCode
from achse.codes.cia import DataType
from achse.codes.ethercat import AlState, AlStatus, ErrorLight
from achse.codes.files import FileRefusal, FoeError
from achse.codes.groups import PlcGroup, ReservedGroup
from achse.codes.lookup import code_of
from achse.codes.nc.errors import NcError
from achse.codes.sdo import AbortCode, SdoAbort, return_code_of

__all__ = [
    "AbortCode",
    "AlState",
    "AlStatus",
    "DataType",
    "ErrorLight",
    "FileRefusal",
    "FoeError",
    "NcError",
    "PlcGroup",
    "ReservedGroup",
    "ReturnCode",
    "SdoAbort",
    "code_of",
    "return_code_of",
]
