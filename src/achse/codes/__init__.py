"""Numbers with names: ADS return codes and NC error codes, read by every other room."""

from achse.codes.ads import ReturnCode
from achse.codes.nc import NcError

__all__ = ["NcError", "ReturnCode"]
