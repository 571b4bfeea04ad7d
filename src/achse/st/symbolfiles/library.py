"""Types of libraries: those that sources name and do not declare, out of `.tmc` files.

A `.tmc` of a built project has every type that its variables are made of, those of libraries
with their real layout.
"""

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, PointerType
from achse.iec.enums import EnumType
from achse.iec.errors import DeclarationError
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.declared.signatures import BlockSignature
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.symbolfiles.tmc import start_values, types_of_tmc
from achse.st.symbolfiles.types import FileTypes
from achse.st.values.values import Constant


class LibraryTypes:
    """The types of `.tmc` files; each is its content and the name it has in faults.

    Of a type in several files the first one counts. Raises `SourceError` with the line if a file
    is at fault, and so do all methods.

    - `beside`: files in the folder of the project; those for another platform are left out;
    - `libraries`: those in the folders of its libraries, read if a name is not in the others; files
      at fault are left out too, and types with pointers of another platform.
    """

    def __init__(
        self,
        files: Iterable[tuple[bytes, str]],
        beside: Iterable[tuple[bytes, str]] = (),
        libraries: Iterable[tuple[bytes, str]] = (),
    ) -> None:
        read = [(*types_of_tmc(data, name), name) for data, name in files]
        for types, root, _ in read:
            if types.pointer_size != read[0][0].pointer_size:
                bits = 8 * read[0][0].pointer_size
                root.fault(
                    f"expected types of a {bits}-bit PLC, like those of {read[0][2]}",
                    Code.BAD_SYMBOL_FILE,
                )
        read += [(*types_of_tmc(data, name), name) for data, name in beside]
        self.pointer_size = read[0][0].pointer_size if read else 8
        """Bytes of a pointer of the PLC they are for."""
        read = [one for one in read if one[0].pointer_size == self.pointer_size]
        self._modules = [(module, types) for types, module, _ in read]
        self.names = [name for _, _, name in read]
        """The files of the project, as faults name them."""
        self._own = [types for types, _, _ in read]
        self._unread_libraries = iter(libraries)
        self._libraries: list[FileTypes] = []

    @property
    def _files(self) -> Iterator[FileTypes]:
        """The types of each file, those of libraries last."""
        yield from self._own
        yield from self._libraries
        for data, name in self._unread_libraries:
            try:
                types, _ = types_of_tmc(data, name)
            except SourceError:
                continue
            self._libraries.append(types)
            yield types

    def type(self, name: str) -> IecType[Any] | None:
        """Return the type of a name, with or without the library in front; None if there is none.

        Raises `DeclarationError` if several libraries have a type of that name.
        """
        _, _, type = self._search(name)
        return type

    def signature(self, name: str) -> BlockSignature | None:
        """Return the signature of a block or interface, by the file that has its type.

        Raises `DeclarationError` like `type`.
        """
        types, whole, _ = self._search(name)
        return None if types is None else types.signature(whole)

    def _search(self, name: str) -> tuple[FileTypes | None, str, IecType[Any] | None]:
        """Return the types of the file that has a name, the whole name there, and its type."""
        for types in self._files:
            names = types.named(name)
            if len(names) > 1:
                # `Lib.FB` and `Other.Lib.FB` are one block, as two libraries reach it.
                shortest = min(names, key=len)
                if all(one == shortest or one.endswith(f".{shortest}") for one in names):
                    names = [shortest]
            if len(names) > 1:
                raise DeclarationError(f"which type is meant: {' or '.join(sorted(names))}?")
            if not names:
                continue
            type = types.type(names[0])
            if type is None or types.pointer_size == self.pointer_size or not _has_pointers(type):
                return types, names[0], type
        return None, "", None

    def enumerations(self, value: str) -> list[EnumType[Any]]:
        """Return the enumerations with a value of that name, which may stand alone.

        Of one that several files have, as of copies of a project's file, the first counts.
        """
        names = {name: types for types in reversed(self._own) for name in types.with_value(value)}
        all_types = [types.type(name) for name, types in names.items()]
        return [type for type in all_types if isinstance(type, EnumType)]

    def constant(self, name: str) -> Constant | None:
        """Return the single value that a variable of a library's list starts with: `List.cMost`.

        A file does not say which of them are CONSTANT; a library that is not here changes none.
        """
        return self._constants.get(name.lower())

    @cached_property
    def _constants(self) -> dict[str, Constant]:
        constants: dict[str, Constant] = {}
        for module, types in self._modules:
            for name, constant in start_values(module, types):
                constants.setdefault(name.lower(), constant)
        return constants

    def has_property(self, block: str, name: str) -> bool:
        """Return True if a block of that name, or its base, has a property of that name."""
        return any(
            types.has_property(qualified, name)
            for types in self._own
            for qualified in types.named(block)
        )


def _has_pointers(type: IecType[Any]) -> bool:
    """Return True if the size of a type differs between platforms."""
    if isinstance(type, ArrayType):
        return _has_pointers(type.element)
    if isinstance(type, AliasType):
        return _has_pointers(type.base)
    if isinstance(type, StructType):
        return any(_has_pointers(member.type) for member in type.members)
    return isinstance(type, PointerType)
