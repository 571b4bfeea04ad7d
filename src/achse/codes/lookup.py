"""The name and text of a code that travels, whichever table has it."""

from achse.codes.ads import ReturnCode
from achse.codes.nc.errors import NcError


def code_of(number: int) -> ReturnCode | NcError | None:
    """Return the ADS return code or NC error of that number; None if no table has it."""
    return ReturnCode.of(number) or NcError.of(number)
