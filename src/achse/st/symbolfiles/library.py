"""Types of libraries: those that sources name and do not declare, out of `.tmc` files.

A `.tmc` of a built project has every type that its variables are made of, those of libraries
with their real layout.
"""

from collections.abc import Iterable
from functools import cached_property
from typing import Any

from achse.iec.enums import EnumType
from achse.iec.errors import DeclarationError
from achse.iec.types import IecType
from achse.st.symbolfiles.tmc import start_values, types_of_tmc
from achse.st.values import Constant

__all__ = ["LibraryTypes"]


class LibraryTypes:
    """The types of `.tmc` files; each is its content and the name it has in faults.

    Of a type in several files the first one counts. Raises `SourceError` with the line if a file
    is at fault, and so do all methods.
    """

    def __init__(self, files: Iterable[tuple[bytes, str]]) -> None:
        read = [(*types_of_tmc(data, name), name) for data, name in files]
        self._modules = [(module, types) for types, module, _ in read]
        self.names = [name for _, _, name in read]
        """The files, as faults name them."""
        self._files = [types for types, _, _ in read]
        self.pointer_size = self._files[0].pointer_size if read else 8
        """Bytes of a pointer of the PLC they are for."""
        for types, root, _ in read:
            if types.pointer_size != self.pointer_size:
                bits = 8 * self.pointer_size
                root.fault(f"expected types of a {bits}-bit PLC, like those of {self.names[0]}")

    def type(self, name: str) -> IecType[Any] | None:
        """The type of a name, with or without the library in front; None if there is none.

        Raises `DeclarationError` if several libraries have a type of that name.
        """
        for types in self._files:
            names = types.named(name)
            if len(names) > 1:
                raise DeclarationError(f"which type is meant: {' or '.join(sorted(names))}?")
            if names:
                return types.type(names[0])
        return None

    def enumerations(self, value: str) -> list[EnumType[Any]]:
        """The enumerations with a value of that name, which may stand alone."""
        found = [types.type(name) for types in self._files for name in types.with_value(value)]
        return [type for type in found if isinstance(type, EnumType)]

    def constant(self, name: str) -> Constant | None:
        """The single value that a variable of a library's list starts with: `List.cMost`.

        A file does not say which of them are CONSTANT; a library that is not here changes none.
        """
        return self._constants.get(name.lower())

    @cached_property
    def _constants(self) -> dict[str, Constant]:
        found: dict[str, Constant] = {}
        for module, types in self._modules:
            for name, constant in start_values(module, types):
                found.setdefault(name.lower(), constant)
        return found

    def has_property(self, block: str, name: str) -> bool:
        """Return True if a block of that name, or its base, has a property of that name."""
        return any(
            types.has_property(found, name) for types in self._files for found in types.named(block)
        )
