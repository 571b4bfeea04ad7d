"""Types that no source declares: elementary ones, those handed in, and those of symbol files."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from achse.iec.declare import Typelike, iec_type
from achse.iec.derived import InterfaceType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.names import elementary
from achse.iec.structs import RecordKind, StructType
from achse.iec.system_types import SYSTEM_TYPES
from achse.iec.types import IecType
from achse.st.declared.signatures import BlockSignature
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.values.values import Constant

_MORE_NAMES = {"ltime_of_day": "ltod", "ldate_and_time": "ldt", "dt": "date_and_time"}
"""DT in a source is DATE_AND_TIME to clients, as recorded."""


class FurtherTypes(Protocol):
    """Source of types that neither sources nor Python code declare: symbol files."""

    @property
    def names(self) -> Sequence[str]:
        """The files, as faults name them."""
        ...

    def type(self, name: str) -> IecType[Any] | None:
        """Return the type of a name. `DeclarationError` if it may mean several."""
        ...

    def enumerations(self, value: str) -> Sequence[EnumType[Any]]:
        """Return the enumerations with a value of that name, which may stand alone."""
        ...

    def constant(self, name: str) -> Constant | None:
        """Return the start value of a variable of a library's list, by `List.variable`."""
        ...

    def has_property(self, block: str, name: str) -> bool:
        """Return True if a block of that name has a property of that name."""
        ...

    def signature(self, name: str) -> BlockSignature | None:
        """Return the signature of a block or interface, None if there is none of that name."""
        ...


class PredefinedTypes:
    """Types by name, without case: handed in (of libraries, of Python code), elementary, `further`.

    A name space in front of a name that is handed in may be left out there.
    """

    def __init__(
        self, types: Mapping[str, Typelike], pointer_size: int, further: FurtherTypes | None = None
    ) -> None:
        self._types = {name.lower(): iec_type(type) for name, type in types.items()}
        self._elementary = elementary(pointer_size)
        self._further = further
        self.has_shells = False
        """True if a symbol file gave a block or an interface, whose methods have no source."""

    def __contains__(self, name: str) -> bool:
        """Return True if a type of that name is passed in."""
        return name.lower() in self._types

    @property
    def handed_in(self) -> Mapping[str, IecType[Any]]:
        """The types that are handed in, by name in lower case."""
        return self._types

    @property
    def files(self) -> Sequence[str]:
        """Symbol files that are searched for types, as faults name them."""
        return () if self._further is None else self._further.names

    def find(self, name: str, at: int) -> IecType[Any] | None:
        """Return the type of a name; raises `Unexpected` if it may mean several."""
        key = name.lower()
        type = self._types.get(key) or self._elementary.get(_MORE_NAMES.get(key, key))
        type = type or SYSTEM_TYPES.get(key)
        while type is None and "." in key:
            key = key.partition(".")[2]
            type = self._types.get(key) or SYSTEM_TYPES.get(key)
        if type is None and self._further is not None:
            try:
                type = self._further.type(name)
            except SourceError:
                raise  # of the file, not of what names the type
            except IecError as doubt:
                raise Unexpected(at, str(doubt), Code.AMBIGUOUS_NAME) from None
            self.has_shells |= isinstance(type, InterfaceType) or (
                isinstance(type, StructType) and type.kind is RecordKind.FUNCTION_BLOCK
            )
        return type

    def values(self, name: str) -> list[Constant]:
        """Values of that name, in lower case, of enumerations in symbol files."""
        return [
            Constant(number, type)
            for type in (self._further.enumerations(name) if self._further else ())
            for value, number in type.numbers.items()
            if value.lower() == name
        ]

    def constant(self, keys: Sequence[str]) -> Constant | None:
        """Return the start value of a variable of a library's list, whose names are in symbol
        files."""
        return None if self._further is None else self._further.constant(".".join(keys[-2:]))

    def has_property(self, block: str, name: str) -> bool:
        """Return True if a block of a symbol file has a property of that name."""
        return self._further is not None and self._further.has_property(block, name)

    def signature(self, name: str) -> BlockSignature | None:
        """Return the signature of a block or interface of a symbol file."""
        return None if self._further is None else self._further.signature(name)
