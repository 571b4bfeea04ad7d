"""Symbols of a device whose values are named one by one, each with its place and its functions."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.iec import IecType
from achse.iec.datatypes import encode_types
from achse.iec.describe import describe_type, types_shown
from achse.iec.symbols import SymbolEntry, SymbolFlag, encode_symbols, fold
from achse.server import TableSizes

_TASK = 1


class ValueSymbol:
    """A value by name; read only (0x704) without `write`. `place`: index group and offset."""

    call: Callable[[bytes], bytes] | None = None
    context = _TASK

    def __init__(
        self,
        name: str,
        type: IecType[Any],
        place: tuple[int, int],
        read: Callable[[], bytes],
        write: Callable[[bytes], None] | None = None,
        comment: str = "",
    ) -> None:
        self.name = name
        self.type = type
        self.index_group, self.index_offset = place
        self.size = type.size
        self.read = read
        self.read_only = write is None
        self.write = write or self._refuse
        self.comment = comment

    def entry(self) -> bytes:
        return self.table_entry().encode()

    def table_entry(self) -> SymbolEntry:
        """Return the symbol as the tables show it."""
        return SymbolEntry.of(
            self.name,
            self.type,
            *(self.index_group, self.index_offset),
            flags=int(SymbolFlag.READ_ONLY) if self.read_only else 0,
            context=self.context,
            comment=self.comment,
        )

    def _refuse(self, data: bytes) -> None:
        raise DeviceError(ReturnCode.INVALID_ACCESS, f"{self.name} is read only")


class ValueSymbols(ABC):
    """The symbols of one device, found at the first request."""

    version = 1

    @abstractmethod
    def all_symbols(self) -> Iterable[ValueSymbol]:
        """Return every symbol in the order of the table; of two with one name the later one
        counts."""

    def used_types(self) -> Iterable[IecType[Any]]:
        """Return the types of the type table; those of the symbols, unless a device has more."""
        return types_shown([symbol.type for symbol in self._symbols.values()])

    def forget(self) -> None:
        """Find the symbols again at the next request; clients see another version."""
        self.version = self.version % 255 + 1
        for name in ("_symbols", "_symbol_table", "_types", "_type_table"):
            vars(self).pop(name, None)

    def resolve(self, name: str) -> ValueSymbol | None:
        """Return a symbol by its name in any case."""
        return self._symbols.get(fold(name.strip()))

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=len(self._symbols), type_count=len(self._types))

    def symbol_table(self) -> bytes:
        return self._symbol_table

    def type_table(self) -> bytes:
        return self._type_table

    def type_entry(self, name: str) -> bytes | None:
        type = self._types.get(fold(name.strip()))
        return None if type is None else describe_type(type).encode()

    @cached_property
    def _symbols(self) -> dict[str, ValueSymbol]:
        return {fold(symbol.name): symbol for symbol in self.all_symbols()}

    @cached_property
    def _symbol_table(self) -> bytes:
        return encode_symbols(symbol.table_entry() for symbol in self._symbols.values())

    @cached_property
    def _types(self) -> dict[str, IecType[Any]]:
        return {fold(type.name): type for type in self.used_types()}

    @cached_property
    def _type_table(self) -> bytes:
        return encode_types(map(describe_type, self._types.values()))
