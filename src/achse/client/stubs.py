"""Python modules generated from the symbols of a target: typed values, typed access by name."""

import keyword
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from achse.iec import (
    ArrayType,
    EnumType,
    IecType,
    Method,
    OpaqueType,
    PointerType,
    StructType,
    resolved,
)
from achse.iec.describe import types_within
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.times import TimeType

__all__ = ["stubs"]

_TIMES = {
    "TIME": "timedelta",
    "DATE": "date",
    "LDATE": "date",
    "TIME_OF_DAY": "time",
    "TOD": "time",
    "DATE_AND_TIME": "datetime",
    "DT": "datetime",
}
"""Python types of time types; the others are Nanoseconds."""

_HEADER = '''"""Symbols of {title}, written by `achse symbols stubs`."""
# ruff: noqa
# fmt: off

from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from enum import IntEnum
from typing import Any

from achse.client import MethodResult, Symbol, Target
from achse.client.typed import iec_name
from achse.iec import Nanoseconds

__all__ = [{exported}]
'''


def stubs(symbols: Mapping[str, IecType[Any]], title: str) -> str:
    """The source of a module for `symbols` (names with their types).

    It has a dataclass for each structure, an `IntEnum` for each enumeration, a class of symbols
    for each first part of a name, and `Symbols(target)` with all of these.
    """
    return "\n".join(_Module(symbols, title).lines()) + "\n"


class _Module:
    def __init__(self, symbols: Mapping[str, IecType[Any]], title: str) -> None:
        self.symbols = symbols
        self.title = title
        self.names: dict[str, str] = {}
        """Python names of enumerations and structures by their IEC name."""
        self.taken = {"Symbols", "Symbol", "Target", "MethodResult", "Any", "Nanoseconds"}
        self.taken |= {"date", "datetime", "time", "timedelta", "IntEnum", "dataclass", "iec_name"}
        self.types = _inner_first(
            sorted(types_within(symbols.values()), key=lambda type: type.name.lower())
        )
        for type in self.types:
            self.names[type.name.lower()] = self._unique(_identifier(type.name))

    def _unique(self, name: str) -> str:
        while name in self.taken:
            name += "_"
        self.taken.add(name)
        return name

    def lines(self) -> Iterator[str]:
        title = self.title.replace("\\", "").replace('"', "'")
        body = [*self._types(), *self._symbols()]
        exported = ", ".join(f'"{name}"' for name in sorted(("Symbols", *self.names.values())))
        yield _HEADER.format(title=title, exported=exported)
        yield from body

    # types -----------------------------------------------------------------------------------

    def _types(self) -> Iterator[str]:
        for type in self.types:
            name = self.names[type.name.lower()]
            yield ""
            if isinstance(type, EnumType):
                yield f"class {name}(IntEnum):"
                members = {_identifier(text): number for text, number in type.numbers.items()}
                yield from (f"    {text} = {number}" for text, number in members.items())
                if not members:
                    yield "    pass"
            elif isinstance(type, StructType):
                yield "@dataclass(kw_only=True)"
                yield f"class {name}:"
                yield from self._fields(type)
            yield ""

    def _fields(self, type: StructType[Any]) -> Iterator[str]:
        seen: set[str] = set()
        for member in type.fields:
            own = _identifier(member.name)
            while own in seen:
                own += "_"
            seen.add(own)
            note = "" if own == member.name else f' = iec_name("{_quoted(member.name)}")'
            yield f"    {own}: {self._hint(member.type)}{note}"
        if not seen:
            yield "    pass"

    def _hint(self, type: IecType[Any]) -> str:
        real = resolved(type)
        if isinstance(real, ArrayType):
            hint = self._hint(real.element)
            for _ in real.dimensions:
                hint = f"list[{hint}]"
            return hint
        if isinstance(real, EnumType):
            return f"{self.names[real.name.lower()]} | int"
        if isinstance(real, StructType):
            return self.names[real.name.lower()]
        if isinstance(real, TimeType):
            return _TIMES.get(real.name, "Nanoseconds")
        if isinstance(real, OpaqueType):
            return "bytes"
        if isinstance(real, BoolType) or real.is_bit:
            return "bool"
        if isinstance(real, RealType):
            return "float"
        if isinstance(real, StringType):
            return "str"
        return "int" if isinstance(real, IntegerType | PointerType) else "Any"

    # symbols ---------------------------------------------------------------------------------

    def _symbols(self) -> Iterator[str]:
        blocks: dict[str, str] = {}
        for type in self.types:
            if isinstance(type, StructType) and type.methods:
                name = self._unique(f"{self.names[type.name.lower()]}Symbol")
                blocks[type.name.lower()] = name
                yield ""
                yield f"class {name}(Symbol[{self.names[type.name.lower()]}]):"
                yield from self._methods({m.name.lower(): m for m in type.methods}.values())
                yield ""
        units: dict[str, list[tuple[str, IecType[Any]]]] = {}
        for name, kind in self.symbols.items():
            units.setdefault(name.partition(".")[0], []).append((name, kind))
        attributes = {}
        for unit, items in units.items():
            own = _identifier(unit) if unit else "globals_"
            attributes[own] = self._unique(f"_{own}")
            yield ""
            yield f"class {attributes[own]}:"
            yield "    def __init__(self, target: Target) -> None:"
            for name, kind in items:
                yield f"        {self._symbol(name, kind, blocks)}"
            yield ""
        yield ""
        yield "class Symbols:"
        yield '    """All symbols of a target: `Symbols(await achse.connect())`."""'
        yield ""
        yield "    def __init__(self, target: Target) -> None:"
        for own, cls in attributes.items():
            yield f"        self.{own} = {cls}(target)"
        if not attributes:
            yield "        pass"

    def _symbol(self, name: str, type: IecType[Any], blocks: Mapping[str, str]) -> str:
        own = _identifier(name.partition(".")[2] or name)
        hint = self._hint(type)
        block = blocks.get(resolved(type).name.lower())
        text = _quoted(name)
        if block is not None:
            return f'self.{own} = {block}(target, "{text}", {hint})'
        return f'self.{own}: Symbol[{hint}] = Symbol(target, "{text}", {hint})'

    def _methods(self, methods: Iterable[Method]) -> Iterator[str]:
        for method in methods:
            inputs = [(item.name, self._hint(item.type)) for item in method.inputs]
            if method.outputs:
                answer = "MethodResult"
            else:
                answer = "None" if method.returns is None else self._hint(method.returns)
            own = {name: _identifier(name) for name, _ in inputs}
            parameters = "".join(f", {own[name]}: {hint}" for name, hint in inputs)
            star = ", *" if inputs else ""
            arguments = ", ".join(f'"{_quoted(name)}": {own[name]}' for name, _ in inputs)
            yield f"    async def {_identifier(method.name)}(self{star}{parameters}) -> {answer}:"
            call = f'await self.call("{_quoted(method.name)}", **{{{arguments}}})'
            if answer == "None":
                yield f"        {call}"
            else:
                yield f"        answer: {answer} = {call}"
                yield "        return answer"
            yield ""


def _inner_first(types: Iterable[IecType[Any]]) -> list[EnumType[Any] | StructType[Any]]:
    """The enumerations and structures, each structure after what it is made of."""
    found: dict[str, EnumType[Any] | StructType[Any]] = {}

    def add(type: IecType[Any]) -> None:
        real = resolved(type)
        if isinstance(real, ArrayType):
            add(real.element)
        elif isinstance(real, EnumType | StructType) and real.name.lower() not in found:
            if isinstance(real, StructType):
                for member in real.fields:
                    add(member.type)
            found[real.name.lower()] = real

    for type in types:
        add(type)
    return list(found.values())


def _identifier(name: str) -> str:
    """A name as Python can have it."""
    own = re.sub(r"\W", "_", name)
    if not own or own[0].isdigit() or own.startswith("__"):
        own = "n" + own
    return f"{own}_" if keyword.iskeyword(own) or own in ("self", "target", "mro") else own


def _quoted(text: str) -> str:
    return re.sub(r'[\\"\x00-\x1f]', "_", text)
