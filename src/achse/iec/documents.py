"""IEC values as people and programs read them: literals, and what JSON has."""

import math
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.enums import EnumType
from achse.iec.errors import IecValueError
from achse.iec.literals import format_value
from achse.iec.structs import StructType, plain
from achse.iec.times import TimeType
from achse.iec.types import IecType


def as_text(type: IecType[Any], value: Any) -> str:
    """Return the IEC literal of `value`; of a type without literals its bytes."""
    try:
        return format_value(type, value)
    except IecValueError:
        return type.encode(value).hex(" ")


def as_json(type: IecType[Any], value: Any) -> Any:
    """`value` of numbers, texts, lists and dictionaries.

    What JSON cannot say (times, enumerations, infinity) is an IEC literal in a string.
    """
    real = resolved(type)
    if isinstance(real, ArrayType):
        return _items(real.element, len(real.counts), plain(value))
    if isinstance(real, StructType):
        return {item.name: as_json(item.type, value[item.name]) for item in real.fields}
    if isinstance(real, EnumType | TimeType) or not isinstance(value, bool | int | float | str):
        return as_text(type, value)
    return value if isinstance(value, str) or math.isfinite(value) else as_text(type, value)


def _items(element: IecType[Any], depth: int, values: list[Any]) -> list[Any]:
    if depth > 1:
        return [_items(element, depth - 1, inner) for inner in values]
    return [as_json(element, item) for item in values]
