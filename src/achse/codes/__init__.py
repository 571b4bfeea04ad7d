"""Numbers with names, read by every other room: errors of ADS, NC, EtherCAT and SDO."""

from achse.codes.ads import ReturnCode
from achse.codes.ethercat import AlState, AlStatus, ErrorLight
from achse.codes.nc import NcError
from achse.codes.sdo import AbortCode, SdoAbort

__all__ = ["AbortCode", "AlState", "AlStatus", "ErrorLight", "NcError", "ReturnCode", "SdoAbort"]
