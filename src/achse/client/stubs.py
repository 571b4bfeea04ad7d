"""Python modules generated from the symbols of a target: typed values, typed access by name."""

import builtins
import keyword
import re
import unicodedata
from collections.abc import Container, Iterable, Iterator, Mapping
from typing import Any

from achse.ams import DeviceError
from achse.client.target import Target
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

_OF_SYMBOLS = ("call", "kind", "name", "read", "samples", "target", "write")
"""Names that the classes of symbols have taken."""

_HEADER = '''"""Symbols of {title}, written by `achse symbols`."""
# ruff: noqa
# fmt: off

from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from enum import IntEnum
from typing import Any

from achse.client import MethodResult, Symbol, Target
from achse.client.typed import ArraySymbol, Callables, iec_name
from achse.iec import Nanoseconds

__all__ = [{exported}]
'''


def stubs(
    symbols: Mapping[str, IecType[Any]],
    title: str,
    programs: Mapping[str, IecType[Any]] | None = None,
) -> str:
    """Return the source of a module for `symbols` (names with their types).

    It has a dataclass for each structure, an `IntEnum` for each enumeration, a class of symbols
    for each first part of a name, and `Symbols(target)` with all of these. `programs` are those
    with methods, by name, which become methods of their class.
    """
    return "\n".join(_Module(symbols, title, programs or {}).lines()) + "\n"


async def programs_of(target: Target, symbols: Iterable[str]) -> dict[str, IecType[Any]]:
    """Return the programs among the first parts of the names that have methods to call."""
    programs: dict[str, IecType[Any]] = {}
    for unit in dict.fromkeys(name.partition(".")[0] for name in symbols):
        try:
            type = await target.type_of(unit)
        except DeviceError:
            continue  # A variable list, or a device that does not list its programs.
        if isinstance(type, StructType) and type.methods:
            programs[unit] = type
    return programs


class _Module:
    def __init__(
        self,
        symbols: Mapping[str, IecType[Any]],
        title: str,
        programs: Mapping[str, IecType[Any]],
    ) -> None:
        self.symbols = symbols
        self.title = title
        self.programs = programs
        self.blocks: dict[str, str] = {}
        """Classes of symbols of what has methods, by the IEC name of its type."""
        self.names: dict[str, str] = {}
        """Python names of enumerations and structures by their IEC name."""
        self.used_names = {
            "ArraySymbol",
            "Callables",
            "Symbols",
            "Symbol",
            "Target",
            "MethodResult",
            "Any",
            "Nanoseconds",
        }
        self.used_names |= {
            *dir(builtins),
            "date",
            "datetime",
            "time",
            "timedelta",
            "IntEnum",
            "dataclass",
            "iec_name",
        }
        self.types = _inner_first(
            sorted(
                types_within([*symbols.values(), *_of_methods(programs.values())]),
                key=lambda type: type.name.lower(),
            )
        )
        for type in self.types:
            self.names[type.name.lower()] = self._unique(_identifier(type.name))

    def _unique(self, name: str) -> str:
        return _free(name, self.used_names)

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
                taken: set[str] = set()
                for text, number in type.numbers.items():
                    yield f"    {_free(_member_name(text), taken)} = {number}"
                if not taken:
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
        for type in self.types:
            if isinstance(type, StructType) and self._is_callable(type):
                own = self.names[type.name.lower()]
                self.blocks[type.name.lower()] = self._unique(f"{own}Symbol")
        for type in self.types:
            if isinstance(type, StructType) and type.name.lower() in self.blocks:
                yield from self._block(type)
        listed: dict[str, dict[str, IecType[Any]]] = {}
        for name, kind in self.symbols.items():
            listed.setdefault(name.partition(".")[0], {})[name] = kind
        for program in self.programs:
            listed.setdefault(program, {})
        attributes: dict[str, str] = {}
        for unit, items in listed.items():
            own = _unlike(_identifier(unit) if unit else "globals_", attributes)
            # Python changes a name with two underscores in front within a class
            attributes[own] = self._unique(f"_{own.lstrip('_')}")
            yield from self._unit(attributes[own], unit, items)
        yield ""
        yield "class Symbols:"
        yield '    """All symbols of a target: `Symbols(await achse.connect())`."""'
        yield ""
        yield "    def __init__(self, target: Target) -> None:"
        for own, cls in attributes.items():
            yield f"        self.{own} = {cls}(target)"
        if not attributes:
            yield "        pass"

    def _block(self, type: StructType[Any]) -> Iterator[str]:
        """Yield the class for the symbols of a function block, or of what has one inside."""
        own = self.names[type.name.lower()]
        yield ""
        yield f"class {self.blocks[type.name.lower()]}(Symbol[{own}]):"
        yield "    def __init__(self, target: Target, name: str) -> None:"
        yield f"        super().__init__(target, name, {own})"
        taken = set(_OF_SYMBOLS)
        for member in type.fields:
            if self._is_callable(member.type):
                attribute = _free(_identifier(member.name), taken)
                expression = self._symbol_expression(
                    f'f"{{name}}.{_quoted(member.name)}"', member.type
                )
                yield f"        self.{attribute} = {expression}"
        yield ""
        yield from self._methods(type.methods, taken)
        yield ""

    def _unit(self, cls: str, unit: str, items: Mapping[str, IecType[Any]]) -> Iterator[str]:
        """Yield the class for a program or variable list."""
        program = self.programs.get(unit)
        methods = program.methods if isinstance(program, StructType) else ()
        yield ""
        yield f"class {cls}{'(Callables)' if methods else ''}:"
        yield "    def __init__(self, target: Target) -> None:"
        if methods:
            yield f'        super().__init__(target, "{_quoted(unit)}")'
        taken = set(_OF_SYMBOLS) if methods else set()
        for name, kind in items.items():
            attribute = _free(_identifier(name.partition(".")[2] or name), taken)
            expression = self._symbol_expression(f'"{_quoted(name)}"', kind)
            hint = f": Symbol[{self._hint(kind)}]" if expression.startswith("Symbol(") else ""
            yield f"        self.{attribute}{hint} = {expression}"
        yield ""
        yield from self._methods(methods, taken)
        yield ""

    def _symbol_expression(self, name: str, type: IecType[Any]) -> str:
        """Return the expression that creates the symbol of a type; `name` is its name in Python."""
        real = resolved(type)
        block = self.blocks.get(real.name.lower())
        if block is not None:
            return f"{block}(target, {name})"
        hint = self._hint(type)
        if isinstance(real, ArrayType):
            block = self.blocks.get(resolved(real.element).name.lower())
            if block is not None:
                element = f"lambda name: {block}(target, name)"
                return f"ArraySymbol(target, {name}, {hint}, {element})"
        return f"Symbol(target, {name}, {hint})"

    def _is_callable(self, type: IecType[Any]) -> bool:
        """Return True if a type or one of its parts has methods."""
        real = resolved(type)
        if isinstance(real, ArrayType):
            return self._is_callable(real.element)
        return isinstance(real, StructType) and (
            bool(real.methods) or any(self._is_callable(member.type) for member in real.fields)
        )

    def _methods(self, methods: Iterable[Method], taken: set[str]) -> Iterator[str]:
        for method in methods:
            returns = "None" if method.returns is None else self._hint(method.returns)
            answer = "MethodResult" if method.outputs else returns
            names: set[str] = set()
            inputs = [
                (_free(_identifier(item.name), names), item.name, self._hint(item.type))
                for item in method.inputs
            ]
            parameters = "".join(f", {own}: {hint}" for own, _, hint in inputs)
            star = ", *" if inputs else ""
            arguments = ", ".join(f'"{_quoted(name)}": {own}' for own, name, _ in inputs)
            call = f'await self.call("{_quoted(method.name)}", {returns}, **{{{arguments}}})'
            name = _free(_identifier(method.name), taken)
            yield f"    async def {name}(self{star}{parameters}) -> {answer}:"
            if answer == "None":
                yield f"        {call}"
            else:
                yield f"        answer: {answer} = {call}"
                yield "        return answer"
            yield ""


def _free(name: str, taken: set[str]) -> str:
    """Return the name, or what it becomes where it is taken; taken from then on."""
    name = _unlike(name, taken)
    taken.add(name)
    return name


def _unlike(name: str, taken: Container[str]) -> str:
    """Return the name, or what it becomes where it is taken."""
    while name in taken:
        name += "_"
    return name


def _of_methods(programs: Iterable[IecType[Any]]) -> Iterator[IecType[Any]]:
    """Yield the types that the methods of programs take and give."""
    for program in programs:
        for method in program.methods if isinstance(program, StructType) else ():
            yield from (item.type for item in method.parameters)
            if method.returns is not None:
                yield method.returns


def _inner_first(types: Iterable[IecType[Any]]) -> list[EnumType[Any] | StructType[Any]]:
    """Return the enumerations and structures, each structure after what it is made of."""
    ordered: dict[str, EnumType[Any] | StructType[Any]] = {}

    def add(type: IecType[Any]) -> None:
        real = resolved(type)
        if isinstance(real, ArrayType):
            add(real.element)
        elif isinstance(real, EnumType | StructType) and real.name.lower() not in ordered:
            if isinstance(real, StructType):
                for member in real.fields:
                    add(member.type)
            ordered[real.name.lower()] = real

    for type in types:
        add(type)
    return list(ordered.values())


def _identifier(name: str) -> str:
    """Return a name as Python can have it, in the form to which Python changes it."""
    own = unicodedata.normalize("NFKC", name)
    own = "".join(sign if f"n{sign}".isidentifier() else "_" for sign in own)
    if not own.isidentifier() or own.startswith("__"):
        own = "n" + own
    return f"{own}_" if keyword.iskeyword(own) or own in ("self", "target", "mro") else own


def _member_name(name: str) -> str:
    """Return a name as a member of an enumeration of Python can have it: `_x_` is reserved."""
    own = _identifier(name)
    return f"n{own}" if own[0] == own[-1] == "_" else own


def _quoted(text: str) -> str:
    return re.sub(r'["\x00-\x1f]', "_", text).replace("\\", r"\\")
