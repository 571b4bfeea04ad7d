"""Values of PLC variables as JSON, by the names of their types: `tc3_jsonxml/symbols.st`.

Source: the manual of Tc3_JsonXml.
"""

import json
import math
from collections.abc import Mapping, Sequence
from datetime import date, datetime, time
from typing import Any

from achse.codes import ReturnCode
from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.plc.routines.builtins import BuiltinContext, FunctionBody
from achse.plc.routines.document_texts import text_at
from achse.plc.routines.symbol_values import members, real_text

_OMITTED = object()
"""Value of what has no form in JSON, such as pointers."""


def plain_value(type: IecType[Any], data: bytes, offset: int = 0) -> Any:
    """Return a value as `json.dumps` takes it: structures are objects, arrays are nested."""
    plain = resolved(type)
    if isinstance(plain, StructType):
        values = ((one.name, _member_value(one, data, offset)) for one in members(plain))
        return {name: value for name, value in values if value is not _OMITTED}
    if isinstance(plain, ArrayType):
        return _plain_array(plain, plain.counts, data, offset)
    if isinstance(plain, PointerType):
        return _OMITTED
    return _scalar(plain, data[offset : offset + plain.size])


def _member_value(member: Any, data: bytes, offset: int) -> Any:
    place = offset + member.offset
    if member.bit is not None:
        return bool(data[place] >> member.bit & 1)
    return plain_value(member.type, data, place)


def _plain_array(
    type: ArrayType[Any], counts: Sequence[int], data: bytes, offset: int
) -> list[Any] | Any:
    step = math.prod(counts[1:]) * type.element.size
    places = (offset + number * step for number in range(counts[0]))
    if len(counts) > 1:
        return [_plain_array(type, counts[1:], data, place) for place in places]
    values = (plain_value(type.element, data, place) for place in places)
    return [None if value is _OMITTED else value for value in values]


def _scalar(type: IecType[Any], data: bytes) -> Any:
    if isinstance(type, BoolType) or type.is_bit:
        return bool(data[0] & 1)
    if isinstance(type, EnumType):
        return int(type.base.decode(data))
    if isinstance(type, IntegerType):
        return type.decode(data)
    if isinstance(type, RealType):
        value = type.decode(data)
        return float(real_text(value, type.size)) if math.isfinite(value) else None
    if isinstance(type, TimeType):
        moment = type.decode(data)
        if isinstance(moment, date | datetime | time):
            return moment.isoformat()
        return type.codec.unpack_from(data)[0]
    return type.decode(data) if isinstance(type, StringType) else _OMITTED


def put_plain(type: IecType[Any], value: Any, data: bytearray, offset: int = 0) -> None:
    """Put a value of JSON into bytes. What it lacks, or what does not fit, stays as it is."""
    plain = resolved(type)
    if isinstance(plain, StructType):
        values = {key.lower(): each for key, each in value.items()} if _is_object(value) else {}
        for member in members(plain):
            if member.name.lower() not in values:
                continue
            each, place = values[member.name.lower()], offset + member.offset
            if member.bit is None:
                put_plain(member.type, each, data, place)
            elif isinstance(each, bool):
                data[place] = data[place] & ~(1 << member.bit) | each << member.bit
    elif isinstance(plain, ArrayType):
        _put_array(plain, plain.counts, value, data, offset)
    elif not isinstance(plain, PointerType):
        _put_scalar(type, plain, value, data, offset)


def _is_object(value: Any) -> bool:
    return isinstance(value, dict)


def _put_array(
    type: ArrayType[Any], counts: Sequence[int], value: Any, data: bytearray, offset: int
) -> None:
    step = math.prod(counts[1:]) * type.element.size
    items = value[: counts[0]] if isinstance(value, list) else ()
    for number, item in enumerate(items):
        if len(counts) > 1:
            _put_array(type, counts[1:], item, data, offset + number * step)
        else:
            put_plain(type.element, item, data, offset + number * step)


def _put_scalar(
    type: IecType[Any], resolved_type: IecType[Any], value: Any, data: bytearray, offset: int
) -> None:
    if isinstance(resolved_type, BoolType) != isinstance(value, bool):
        return
    try:
        if isinstance(resolved_type, TimeType) and isinstance(value, str):
            kind = resolved_type.to_python(0).__class__
            value = kind.fromisoformat(value.removesuffix("Z")) if kind in _MOMENTS else value
        elif isinstance(resolved_type, IntegerType | EnumType) and isinstance(value, float):
            value = int(value) if value.is_integer() else value
        elif isinstance(resolved_type, StringType) and not isinstance(value, str):
            return
        type.write(data, offset, value)
    except (IecError, ValueError, OverflowError):
        return


_MOMENTS = (date, datetime, time)


def shown_attributes(type: IecType[Any], names: Sequence[str]) -> dict[str, Any]:
    """Return the attributes of the members that have any of these, by the name of the member."""
    plain = resolved(type)
    wanted = {name.strip().lower() for name in names}
    attributes: dict[str, Any] = {}
    for member in members(plain) if isinstance(plain, StructType) else ():
        own: dict[str, Any] = {
            name: value for name, value in member.attributes.items() if name.lower() in wanted
        }
        own |= shown_attributes(member.type, names)
        if own:
            attributes[member.name] = own
    return attributes


# what programs call ---------------------------------------------------------------------------


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def _type(plc: BuiltinContext, name: int, size: int, address: int) -> IecType[Any] | None:
    """Return the type of that name, of no name that of the variable there, if it has the size."""
    text = text_at(plc, name)
    if text:
        type = plc.type_named(text)
    else:
        symbol = plc.symbol_at(address, size)
        type = None if symbol is None else symbol.type
    return type if type is not None and type.size == size else None


def _stored(plc: BuiltinContext, text: str, target: int, room: int) -> int:
    """Store a text with its NUL, if there is a target with room; return its bytes with the NUL."""
    data = text.encode("utf-8") + b"\0"
    if target and room:
        plc.store_bytes(target, data if len(data) <= room else b"\0")
    return len(data)


def _from_symbol(
    plc: BuiltinContext, name: int, size: int, address: int, target: int, room: int
) -> int:
    type = _type(plc, name, size, address)
    if type is None:
        return 0
    plc.spend(size)
    value = plain_value(type, plc.load_bytes(address, size))
    return 0 if value is _OMITTED else _stored(plc, _json(value), target, room)


def _to_symbol(plc: BuiltinContext, text: int, name: int, size: int, address: int) -> int:
    type = _type(plc, name, size, address)
    if type is None:
        return ReturnCode.SYMBOL_NOT_FOUND.number
    try:
        value = json.loads(text_at(plc, text))
    except (ValueError, RecursionError):
        return ReturnCode.SYNTAX.number
    plc.spend(size)
    data = bytearray(plc.load_bytes(address, size))
    put_plain(type, value, data)
    plc.store_bytes(address, bytes(data))
    return 0


def _properties(plc: BuiltinContext, name: int, properties: int, target: int, room: int) -> int:
    type = plc.type_named(text_at(plc, name))
    if type is None:
        return 0
    shown = shown_attributes(type, text_at(plc, properties).split("|"))
    return _stored(plc, _json(shown), target, room)


def _type_name(plc: BuiltinContext, size: int, address: int) -> bytes:
    symbol = plc.symbol_at(address, size)
    return b"" if symbol is None else symbol.type.name.encode("cp1252", "replace")[:255]


def _symbol_name(plc: BuiltinContext, size: int, address: int) -> bytes:
    symbol = plc.symbol_at(address, size)
    return b"" if symbol is None else symbol.name.encode("cp1252", "replace")[:255]


JSON_SYMBOL_FUNCTIONS: Mapping[str, FunctionBody] = {
    "json_from_symbol": _from_symbol,
    "json_to_symbol": _to_symbol,
    "json_properties": _properties,
    "json_type_name": _type_name,
    "json_symbol_name": _symbol_name,
}
"""Built-in functions of Tc3_JsonXml for variables, by key."""
