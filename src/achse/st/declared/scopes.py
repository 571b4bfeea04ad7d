"""Names: what is declared where, and the constants that names stand for.

Source: IEC 61131-3 (2013) tables 11 and 13.
"""

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar

from achse import libraries
from achse.iec.errors import IecError
from achse.iec.types import IecType
from achse.st.declared.standard import LibraryFile, LibraryUnit
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.outlines import UnitOutline, outline_of
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import (
    Declaration,
    EnumOf,
    NamedType,
    VarBlock,
)
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import (
    FunctionBlock,
    GlobalList,
    Interface,
    Namespace,
    Part,
    Program,
    Property,
    TypeDeclaration,
    Unit,
)
from achse.st.values.constants import Path
from achse.st.values.values import Constant

T = TypeVar("T")

DEEPEST = 64
"""Deepest chain of types and constants that are declared by others."""


class Failed(Exception):
    """Something needed is at fault itself; that was reported in its place."""


@dataclass(slots=True, eq=False)
class DeclaredUnit:
    """A declared unit: `name` with its name space, and the type made of it once it is."""

    name: str
    _tree: Unit | LibraryUnit
    source: Source
    space: str
    is_library: bool
    building: bool = False
    failed: bool = False
    type: IecType[Any] | None = None
    is_built_in: bool = False
    """True if the unit is of a library that achse has."""

    @property
    def tree(self) -> Unit:
        """Its syntax tree."""
        tree = self._tree
        if isinstance(tree, LibraryUnit):
            tree = self._tree = tree.file.unit(tree.number)
        return tree

    @property
    def is_used(self) -> bool:
        """True if its syntax tree was needed; always True for units of the user."""
        return not isinstance(self._tree, LibraryUnit)

    def declare_again(self, tree: Unit | LibraryUnit, source: Source) -> None:
        """Forget the type, which is made again of a tree."""
        if not isinstance(tree, LibraryUnit):
            self._tree, self.source = tree, source
        self.building, self.failed, self.type = False, False, None

    def is_declared_by(self, tree: Unit | LibraryUnit, source: Source) -> bool:
        """Return True if this tree of this source declares the unit."""
        return self.source is source and (self._tree is tree or isinstance(tree, LibraryUnit))

    @property
    def is_interface(self) -> bool:
        """True if the unit is an interface, even in a library that is not parsed."""
        tree = self._tree
        if isinstance(tree, LibraryUnit):
            return tree.file.outlines[tree.number].kind == Interface.__name__
        return isinstance(tree, Interface)

    @property
    def at(self) -> int:
        """Offset of the unit in its source, even in a library that is not parsed."""
        tree = self._tree
        return tree.file.outlines[tree.number].at if isinstance(tree, LibraryUnit) else tree.at


References: TypeAlias = Mapping[str, Mapping[str, Sequence[str]]]
"""Libraries that come with achse, as the project (empty name) and each library reference them, with
the name spaces of each reference: of units with one name the first library is meant."""

Declared: TypeAlias = tuple[VarBlock, Declaration]


@dataclass(slots=True, eq=False)
class Scope:
    """The names that a unit sees first: its own variables, then those of its base."""

    source: Source
    owner: str
    space: str = ""
    base: "Scope | None" = None
    extends: NamedType | None = None
    """The base that no source declares."""
    variables: dict[str, Declared] = field(default_factory=dict)
    values: dict[str, Constant] = field(default_factory=dict)
    """Values of enumerations declared inside."""
    heights: dict[str, int] = field(default_factory=dict)
    """Levels that its constants rest on, and its type, of which the name is empty."""
    constants: dict[str, Constant | None] = field(default_factory=dict)
    """Constants already computed; None while one is being computed."""
    failed: set[str] = field(default_factory=set)
    """Constants with a reported fault."""


def _library_of(source: Source) -> str:
    """Return the name space of a library: its namespace in the project, or the folder of a library
    that comes with achse."""
    if source.library:
        return source.library
    folder, slash, _ = source.path.partition("/")
    if not slash or folder not in libraries.names():
        return ""
    return "__SYSTEM" if folder == "language" else folder


def with_bases(scope: Scope) -> Iterator[Scope]:
    """Yield a scope and its bases, which faulty sources may close to a ring."""
    seen: set[int] = set()
    here: Scope | None = scope
    while here is not None and id(here) not in seen:
        yield here
        seen.add(id(here))
        here = here.base


def is_instance_of_any(key: str, units: Container[str]) -> bool:
    """Return True if the key of a block names one of these units, in lower case.

    The key of a generic block has its constants too, that of a base the block that it is laid out
    for.
    """
    if "<" not in key:
        return key in units
    return any(name in units for name in re.split("[<>,]", key))


def _by_space(libraries: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return the library of each name space, in lower case; of two the first."""
    pairs = [(space.lower(), name) for name, spaces in libraries.items() for space in spaces]
    return dict(reversed(pairs))


class Scopes:
    """Everything declared, by name and without case; faults are collected in `faults`."""

    def __init__(self, references: References | None = None) -> None:
        self._references = {key.lower(): value for key, value in (references or {}).items()}
        self._spaces = {key: _by_space(value) for key, value in self._references.items()}
        self.faults: dict[Diagnostic, None] = {}
        self.entries: dict[str, DeclaredUnit] = {}
        self.globals: dict[str, list[DeclaredUnit]] = {}
        """Lists by the variables that need no list in front, in lower case."""
        self.loose_values: dict[str, list[DeclaredUnit]] = {}
        """Enumerations by the values that need no type in front."""
        self.list_properties: dict[str, list[DeclaredUnit]] = {}
        """Variable lists by the properties that need no list in front."""
        self._of_libraries: dict[str, dict[str, DeclaredUnit]] = {}
        """Units of libraries, by library and by name, in lower case: they do not see units of the
        project with the same name."""
        self._scopes: dict[DeclaredUnit, Scope] = {}
        self._depth = 0
        self.height = 0
        """Deepest level so far on which something was declared."""
        self._earlier: dict[str, DeclaredUnit] = {}
        """Units before `declare_again`, which stay the same objects."""

    # what is declared ----------------------------------------------------------------------

    @contextmanager
    def declared_again(self, units: Container[str]) -> Iterator[None]:
        """Let all sources be added again meanwhile; units that are not among `units`, keys in
        lower case, keep their types."""
        earlier = self._earlier = self.entries
        self._scopes = {
            entry: scope
            for entry, scope in self._scopes.items()
            if not is_instance_of_any(entry.name.lower(), units)
        }
        self.faults, self.entries, self.height = {}, {}, 0
        self.globals, self.loose_values, self.list_properties = {}, {}, {}
        self._of_libraries = {}
        yield
        for key, entry in earlier.items():
            if key in units and self.entries.get(key) is entry:
                entry.declare_again(entry.tree, entry.source)
        self._earlier = {}

    def add(self, sources: Iterable[Parsed], *, is_library: bool = False) -> None:
        """Take in the units of sources. What a library declares gives way to the user's own."""
        for parsed in sources:
            for unit in parsed.units:
                self._add_unit(unit, parsed.source, "", is_library)

    def add_files(self, files: Iterable[LibraryFile]) -> None:
        """Take in the units of libraries that come with achse, without parsing them.

        Those that the project references precede.
        """
        ranks = {name: rank for rank, name in enumerate(self._references.get("", ()))}
        for file in sorted(files, key=lambda file: ranks.get(file.source.library, len(ranks))):
            self._add_file(file)

    def _add_file(self, file: LibraryFile) -> None:
        source, library = file.source, file.source.library
        entries, before = self.entries, self._earlier
        own = self._of_libraries.setdefault(library.lower(), {})
        if source.namespace:
            self._of_libraries.setdefault(source.namespace.lower(), own)
        for key, outline, tree in file.listed:
            if outline.kind == Namespace.__name__:
                self._add_unit(tree.file.unit(tree.number), source, "", True)
                continue
            entry = before.get(key)
            is_other = entry is not None and entry.source is not source
            if key in entries or is_other or outline.is_internal or key.startswith("__"):
                self._add(outline, tree, source, "", True)
                continue
            if entry is None:
                entry = DeclaredUnit(outline.name, tree, source, library, True, is_built_in=True)
            entries[key] = own[key] = entry
            if outline.variables or outline.properties or outline.values:
                self._add_contents(outline, entry)

    def _add_unit(self, unit: Unit, source: Source, space: str, is_library: bool) -> None:
        if isinstance(unit, Namespace):
            name = f"{space}.{unit.name}" if space else unit.name
            for inner in unit.units:
                self._add_unit(inner, source, name, is_library)
        else:
            self._add(outline_of(unit), unit, source, space, is_library)

    def _add(
        self,
        unit: UnitOutline,
        tree: Unit | LibraryUnit,
        source: Source,
        space: str,
        is_library: bool,
    ) -> None:
        name = f"{space}.{unit.name}" if space else unit.name
        key = name.lower()
        known = self.entries.get(key)
        library = _library_of(source) if is_library else ""
        if known is not None or (library and unit.is_internal):
            if known and not is_library:
                first = known.source.locate(known.tree.at)
                self.report(
                    source, unit.at, f"{name} is declared already, at {first}", Code.DUPLICATE_NAME
                )
                return
            if known and (not library or library == _library_of(known.source)):
                return
            # For the library itself and with its name space: `Tc2_Standard.CONCAT`.
            name = f"{library}.{name}"
            if name.lower() in self.entries:
                return
        elif unit.name.startswith("__"):
            self.report(
                source,
                unit.at,
                "names with two underscores in front are reserved",
                Code.RESERVED_NAME,
            )
            return
        entry = self._earlier.get(name.lower())
        if entry is None or entry.is_library != is_library or entry.space != (space or library):
            entry = DeclaredUnit(name, tree, source, space or library, is_library)
            entry.is_built_in = isinstance(tree, LibraryUnit)
        elif not entry.is_declared_by(tree, source):
            entry.declare_again(tree, source)
        self.entries[name.lower()] = entry
        if library:
            own = self._of_libraries.setdefault(library.lower(), {})
            own[key] = entry
            if source.namespace:
                self._of_libraries.setdefault(source.namespace.lower(), own)
        self._add_contents(unit, entry)

    def _add_contents(self, unit: UnitOutline, entry: DeclaredUnit) -> None:
        for key in unit.variables:
            self.globals.setdefault(key, []).append(entry)
        for key in unit.properties:
            self.list_properties.setdefault(key, []).append(entry)
        for key in unit.values:
            self.loose_values.setdefault(key, []).append(entry)

    def find(self, name: str, space: str = "") -> DeclaredUnit | None:
        """Return the unit of a name as seen from a name space. Names of libraries in front of it
        that nothing here declares are passed over: `Tc2_MC2.AXIS_REF` is AXIS_REF."""
        key = name.lower()
        prefix = space.lower()
        head, dot, rest = key.partition(".")
        if dot and (unit := self._units_of(head, prefix).get(rest)) is not None:
            return unit
        if prefix in self._of_libraries and (unit := self._in_libraries(key, prefix)):
            return unit
        while prefix:
            if unit := self.entries.get(f"{prefix}.{key}"):
                return unit
            prefix = prefix.rpartition(".")[0]
        while True:
            if unit := self.entries.get(key):
                return unit
            _, dot, key = key.partition(".")
            if not dot:
                return None

    def _in_libraries(self, key: str, library: str) -> DeclaredUnit | None:
        """Return a name as one library sees it: its own, that of a library that it references, else
        that of another library where the project has that name, too."""
        if unit := self._of_libraries[library].get(key):
            return unit
        for name in self._references.get(library, ()):
            if unit := self._of_libraries.get(name, {}).get(key):
                return unit
        known = self.entries.get(key)
        if known and known.is_library:
            return known
        units = (units[key] for units in self._of_libraries.values() if key in units)
        return next(units, None)

    def _units_of(self, name: str, space: str = "") -> Mapping[str, DeclaredUnit]:
        """Return the units of the library that a name space or title means in a name space."""
        spaces = self._spaces.get(space if space in self._of_libraries else "", {})
        return self._of_libraries.get(spaces.get(name, name), {})

    def is_of_library(self, key: str) -> bool:
        """Return True if a library has a unit of that name, or is called so, in lower case."""
        known = self.entries.get(key)
        return (
            (known is not None and known.is_library)
            or key in self._of_libraries
            or any(key in units for units in self._of_libraries.values())
        )

    def library_named(self, name: str) -> str:
        """Return the name space of a library as it is written before names; empty without one."""
        units = self._units_of(name.lower())
        return "" if not units else next(iter(units.values())).space

    def _visible(
        self,
        candidates: Sequence[DeclaredUnit],
        key: str,
        space: str,
    ) -> Sequence[DeclaredUnit]:
        """Of things with one name, those that the name alone means in a name space.

        Whatever else has the name (variable, value, property, unit) hides those farther away.
        """
        if not candidates:
            return candidates
        spaces = [item.space for item in self.globals.get(key, ())]
        spaces += [item.space for item in self.loose_values.get(key, ())]
        spaces += [item.space for item in self.list_properties.get(key, ())]
        if (unit := self.find(key, space)) is not None:
            spaces.append(unit.space)
        nearest = min(self._distance(other, space) for other in spaces)
        return [item for item in candidates if self._distance(item.space, space) == nearest]

    def _distance(self, other: str, space: str) -> int:
        """0 for the name space itself; from a library other libraries are next, from the project
        the project."""
        if other == space:
            return 0
        if space.lower() in self._of_libraries:
            return 1 if other.lower() in self._of_libraries else 2
        return 2 if other else 1

    def global_variables(self, key: str, space: str) -> Sequence[tuple[Scope, Declared]]:
        """Return the variables of lists that a name alone means, seen from a name space."""
        named = self.globals.get(key)
        if named is None:
            return ()
        lists = self._visible(named, key, space)
        scopes = map(self.scope, lists)
        return [(scope, scope.variables[key]) for scope in scopes]

    def values_of_enumerations(self, key: str, space: str) -> Sequence[DeclaredUnit]:
        """Return the enumerations of which a value is meant by its name alone, seen from a name
        space."""
        return self._visible(self.loose_values.get(key, ()), key, space)

    def lists_with_property(self, key: str, space: str) -> Sequence[DeclaredUnit]:
        """Return the variable lists of which a property is meant by its name alone."""
        return self._visible(self.list_properties.get(key, ()), key, space)

    def forget(self, entry: DeclaredUnit) -> None:
        """Forget the scope inside a unit, which is made again of its tree."""
        self._scopes.pop(entry, None)

    @property
    def cached_scopes(self) -> Iterable[Scope]:
        """Scopes inside units that were requested so far."""
        return self._scopes.values()

    def scope(self, entry: DeclaredUnit) -> Scope:
        """Return the scope inside a unit."""
        scope = self._scopes.get(entry)
        if scope is None:
            scope = Scope(entry.source, entry.name, entry.space)
            self._scopes[entry] = scope
            tree = entry.tree
            if isinstance(tree, FunctionBlock | TypeDeclaration) and tree.extends is not None:
                base = self.find(tree.extends.name, entry.space)
                if base is not None and isinstance(base.tree, type(tree)):
                    scope.base = self.scope(base)
                elif base is None:
                    scope.extends = tree.extends
            for block in blocks_of(tree):
                for declaration in block.variables:
                    for item in declaration.names:
                        scope.variables.setdefault(item.name.lower(), (block, declaration))
        return scope

    # faults --------------------------------------------------------------------------------

    def report(self, source: Source, at: int, message: str, code: Code) -> None:
        """Keep a fault; equal faults are reported once."""
        self.faults.setdefault(source.fault(at, message, code))

    @contextmanager
    def inside(self, source: Source) -> Iterator[None]:
        """Report what goes wrong inside as a fault of this source, and raise `Failed`."""
        self._go_deeper()
        try:
            yield
        except Unexpected as fault:
            self.report(source, fault.at, fault.message, fault.code)
            raise Failed from None
        finally:
            self._depth -= 1

    @contextmanager
    def deeper(self) -> Iterator[None]:
        """One level deeper, without another source."""
        self._go_deeper()
        try:
            yield
        finally:
            self._depth -= 1

    def _go_deeper(self) -> None:
        self._depth += 1
        self.height = max(self.height, self._depth)

    @contextmanager
    def measured(self, heights: dict[str, int], key: str) -> Iterator[None]:
        """Note the levels that a type or constant rests on."""
        outside, self.height = self.height, self._depth
        try:
            yield
        finally:
            heights[key] = self.height - self._depth
            self.height = max(outside, self.height)

    def rest_on(self, height: int) -> None:
        """Note the levels of a type or constant that is known already."""
        self.height = max(self.height, self._depth + height)

    @contextmanager
    def without_new_faults(self) -> Iterator[set[DeclaredUnit]]:
        """Forget the faults that are reported meanwhile, and that units failed: a later request
        reports them again. The yielded set has these units then."""
        known, before = len(self.faults), self._failed()
        failed: set[DeclaredUnit] = set()
        yield failed
        for fault in list(self.faults)[known:]:
            del self.faults[fault]
        failed |= self._failed() - before
        for entry in failed:
            entry.failed = False
            self._scopes.pop(entry, None)

    def _failed(self) -> set[DeclaredUnit]:
        return {entry for entry in self.entries.values() if entry.failed}

    def check_depth(self, at: int) -> None:
        """Raise `Unexpected` if declarations rest on each other too deep."""
        if self._depth > DEEPEST:
            raise Unexpected(
                at, f"declarations rest on each other more than {DEEPEST} deep", Code.TOO_DEEP
            )

    @staticmethod
    def build(make: Callable[[], T], at: int) -> T:
        """Return the result of `make`; an error of the type system becomes an error of the
        source."""
        try:
            return make()
        except IecError as error:
            raise Unexpected(at, str(error), Code.BAD_DECLARATION) from None

    # what is where -----------------------------------------------------------------------------

    def has_property(self, block: str, name: str) -> bool:
        """Return True if a function block of that name, or its base, has that PROPERTY."""
        entry = self.find(block.partition("<")[0])
        while entry is not None and isinstance(tree := entry.tree, FunctionBlock):
            if any(isinstance(p, Property) and p.name.lower() == name.lower() for p in tree.parts):
                return True
            base = tree.extends
            entry = None if base is None else self.find(base.name, entry.space)
        return False

    def is_property(self, key: str, scope: Scope) -> bool:
        """Return True if a name alone means a property: of the block or list that a scope is in, of
        a block that it extends, or of a variable list."""
        for here in with_bases(scope):
            entry = self.entries.get(here.owner.partition("<")[0].lower())
            parts: Sequence[Part] = () if entry is None else getattr(entry.tree, "parts", ())
            if any(isinstance(part, Property) and part.name.lower() == key for part in parts):
                return True
        return bool(self.lists_with_property(key, scope.space))

    def variable(self, path: Path, scope: Scope) -> tuple[Scope, list[str]] | None:
        """Return the scope that declares the first variable of a path, and the names from the
        variable on."""
        keys = [part.lower() for part in path]
        if (own := self.own(keys[0], scope)) is not None:
            return own[0], keys
        for cut in range(1, len(keys)):
            entry = self.find(".".join(keys[:cut]), scope.space)
            if entry is not None and keys[cut] in self.scope(entry).variables:
                return self.scope(entry), keys[cut:]
        if matches := self.global_variables(keys[0], scope.space):
            return matches[0][0], keys
        library = self.library_named(keys[0])
        if library and len(keys) > 1 and (matches := self.global_variables(keys[1], library)):
            return matches[0][0], keys[1:]
        return None

    def is_placed(self, scope: Scope) -> bool:
        """Return True if the variables of a scope are in a list or a program, which exists once."""
        entry = self.entries.get(scope.owner.lower())
        return entry is not None and isinstance(entry.tree, GlobalList | Program)

    def is_enum(self, name: str, space: str) -> bool:
        """Return True if `State.Idle` means a value, though a variable has the name `State` like
        its type."""
        entry = self.find(name, space)
        tree = None if entry is None else entry.tree
        return isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf | NamedType)

    def own(self, key: str, scope: Scope) -> tuple[Scope, Declared] | None:
        """Return the variable of that name in a scope or in those it extends."""
        if (variable := scope.variables.get(key)) is not None:
            return scope, variable
        if scope.base is None:
            return None
        for here in with_bases(scope):
            if (variable := here.variables.get(key)) is not None:
                return here, variable
        return None
