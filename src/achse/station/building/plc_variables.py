"""Variables of a PLC that parts of the station read and write by name."""

import math
from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.devices.plc import PlcDevice
from achse.devices.plc.symbols import PlcSymbol
from achse.iec import EnumType, IecType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.nearest import did_you_mean
from achse.station.configuration.types import ConfigError


def find_variable(device: PlcDevice, name: str, key: str) -> PlcSymbol:
    """Return the variable of that name; `key` names it in errors. Raises ConfigError."""
    symbols = device.symbols
    assert symbols is not None
    try:
        symbol = symbols.source.resolve(name)
    except DeviceError as refusal:
        raise ConfigError(f"{key}: {name}: {refusal.context or refusal}") from None
    if not isinstance(symbol, PlcSymbol) or symbol.call is not None:
        known = (placed.name for placed in device.plc.variables)
        near = did_you_mean(name, known)
        raise ConfigError(f"{key}: expected a variable of the PLC, got {name!r}{near}")
    return symbol


def written_variable(device: PlcDevice, name: str, key: str) -> PlcSymbol:
    """Return the variable of that name; a constant is refused. Raises ConfigError."""
    symbol = find_variable(device, name, key)
    if symbol.read_only:
        raise ConfigError(f"{key}: {name} is a constant")
    return symbol


def is_numeric(type: IecType[Any]) -> bool:
    """Return True for numbers, enumerations and BOOL."""
    return isinstance(type, IntegerType | RealType | BoolType | EnumType)


_SINGLE, _LARGEST_SINGLE = 4, 3.4028234663852886e38
"""Bytes and largest number of a REAL."""


def encoder_of(type: IecType[Any], what: str) -> Callable[[float], bytes]:
    """Return the function that encodes a number as that type: rounded, and kept within its range.

    A counter beyond the range continues at the other end of the range. Raises ConfigError.
    """
    real = resolved(type)
    if isinstance(real, EnumType):
        real = real.base
    if isinstance(real, BoolType):
        return lambda value: b"\1" if value > 0 else b"\0"
    if isinstance(real, RealType):
        encode_real = real.encode
        if real.size > _SINGLE:
            return lambda value: encode_real(value)

        def single(value: float) -> bytes:
            if _LARGEST_SINGLE < abs(value) < math.inf:
                value = math.copysign(_LARGEST_SINGLE, value)
            return encode_real(value)

        return single
    if not isinstance(real, IntegerType):
        raise ConfigError(f"{what}: expected a number or a BOOL, got a {type.name}")
    encode, low, high = real.encode, real.low, real.high
    span = high - low + 1

    def whole(value: float) -> bytes:
        if isinstance(value, int):
            return encode((value - low) % span + low)
        return encode(min(max(round(value), low), high))

    return whole
