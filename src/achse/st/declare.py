"""Declarations: parsed sources as the types, programs and variable lists that Python would declare.

All sources of a project are taken together and worked through in the order they depend on each
other. What comes out are the objects of `achse.iec.declare`: record classes, enumeration types,
`Variable`s with sections, addresses, attributes and initial values.

Initial values that are not constants (`ADR(x)`, of a variable, of a function) become start values
of their variables: the PLC works them out when it lays out its memory.

Source: IEC 61131-3 (2013) tables 11, 13, 40 and 47.
"""

from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

from achse.iec.declare import GlobalVariables, Program, Typelike
from achse.iec.layout import TC3_X64, LayoutRules
from achse.iec.structs import StaticRecord as UnitRecord
from achse.iec.types import IecType
from achse.st.declared.predefined import FurtherTypes
from achse.st.declared.resolve import Resolver, generics_of
from achse.st.declared.scopes import DeclaredUnit, Failed, References, Scope
from achse.st.declared.standard import library_files
from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import Expression, TypeSpec, VarBlock
from achse.st.syntax.units import (
    Accessor,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Part,
    Property,
    TypeDeclaration,
    Unit,
)
from achse.st.syntax.units import Program as ProgramTree
from achse.st.values.values import NotConstant

_HINT = (
    "types of libraries come from `libraries`: their sources, or stubs of them; or from the .tmc of"
    " the built project, there or beside the sources;"
    " achse check --stubs FOLDER writes declarations to start from"
)


@dataclass(frozen=True, slots=True)
class Declarations:
    """Declarations of a project; names are keys in lower case, values have them as written."""

    types: Mapping[str, IecType[Any]]
    """Structures, unions, enumerations, aliases, function blocks, interfaces."""
    globals: Mapping[str, type[GlobalVariables]]
    programs: Mapping[str, type[Program]]
    trees: Mapping[str, Unit]
    """The syntax tree of every unit, functions included."""
    names: Resolver
    """Resolver of every name, for the checker."""

    @property
    def units(self) -> list[type[UnitRecord]]:
        """Variable lists, then programs: what a PLC places."""
        return [*self.globals.values(), *self.programs.values()]


RoutineTree: TypeAlias = Function | Method | Accessor


def declare(
    sources: Iterable[Parsed],
    *,
    libraries: Iterable[Parsed] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules = TC3_X64,
    further: FurtherTypes | None = None,
) -> Declarations:
    """Declare what the sources say. Raises `SourceError` with every fault found.

    Of `libraries` only what the sources name is declared, so that a fault elsewhere in them does
    no harm. `types` and `constants` are those of libraries that come without sources, by name;
    `further` has types that are in neither.
    """
    sources = list(sources)
    faults = [fault for parsed in sources for fault in parsed.faults]
    if faults:
        raise SourceError(faults)
    declarations, fault = examine(
        sources,
        libraries=libraries,
        types=types,
        constants=constants,
        rules=rules,
        further=further,
    )
    if fault is not None:
        raise fault
    return declarations


@collection_paused()
def examine(
    sources: Iterable[Parsed],
    *,
    libraries: Iterable[Parsed] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules = TC3_X64,
    further: FurtherTypes | None = None,
    references: References | None = None,
) -> tuple[Declarations, SourceError | None]:
    """Return the possible declarations of the sources, and an error with all faults or None: as
    `declare`, for callers that continue with the rest. `references` decide between libraries that
    come with achse and have a name in common."""
    sources, libraries = list(sources), list(libraries)
    names = Resolver(types or {}, constants or {}, rules, further, references)
    names.scopes.add(sources)
    names.scopes.add(libraries, is_library=True)
    names.scopes.add_files(library_files())
    declarations = _Declarer(names).declare()
    faults = faults_of(sources, libraries, names.scopes.faults, named_sources(names))
    if not faults:
        return declarations, None
    return declarations, SourceError(faults, _hint(names.unknown_types))


@collection_paused()
def declare_again(
    names: Resolver,
    sources: Iterable[Parsed],
    libraries: Iterable[Parsed],
    units: Collection[str],
    words: Collection[str],
) -> Declarations:
    """Return the declarations of changed sources, in which units keep their types that are not
    among `units`, keys in lower case.

    `units` has all that an edit touches: what changed sources declare and declared, and what names
    one of `words` in its declarations; `words` are the names of these units and of their contents.
    """
    with names.scopes.declared_again(units):
        names.forget(units, words)
        names.scopes.add(sources)
        names.scopes.add(libraries, is_library=True)
        names.scopes.add_files(library_files())
    return _Declarer(names).declare(units)


def has_good_locals(names: Resolver, entry: DeclaredUnit, routine: RoutineTree) -> bool:
    """Declare the variables of a routine of a unit once more; return True if they have no fault.

    What is at fault is reported then.
    """
    known = len(names.scopes.faults)
    declarer = _Declarer(names)
    if isinstance(routine, Function):
        names.scopes.forget(entry)
        declarer.check_inside(routine.blocks, routine.returns, names.scopes.scope(entry))
    else:
        declarer.check_part(routine, None, names.scopes.scope(entry), getattr(routine, "name", ""))
    names.check_pointers()
    return len(names.scopes.faults) == known


def named_sources(names: Resolver) -> frozenset[Source]:
    """Return the sources of which a type was declared."""
    entries = names.scopes.entries.values()
    return frozenset(entry.source for entry in entries if entry.type is not None)


def faults_of(
    sources: Iterable[Parsed],
    libraries: Iterable[Parsed],
    declared: Iterable[Diagnostic],
    named: Container[Source],
) -> list[Diagnostic]:
    """Return the faults of the syntax and of declarations, each once; of libraries those that
    matter: if there are others, or if the project names something of the file."""
    faults = [fault for parsed in sources for fault in parsed.faults]
    faults += declared
    faults += [
        fault for parsed in libraries if faults or parsed.source in named for fault in parsed.faults
    ]
    return list(dict.fromkeys(faults))


def _hint(unknown: Iterable[str]) -> str:
    names = sorted(unknown, key=lambda name: (name.lower(), name))
    if not names:
        return ""
    return f"missing types: {', '.join(names)}\n{_HINT}" if len(names) > 1 else _HINT


class _Declarer:
    """Walks all units once, and makes what they declare."""

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self._scopes = names.scopes

    def declare(self, among: Container[str] | None = None) -> Declarations:
        """Declare all units, or those among some, keys in lower case."""
        every = [entry for entry in self._scopes.entries.values() if not entry.is_library]
        own = [one for one in every if among is None or one.name.lower() in among]
        for entry in own:
            self._collect_addresses(entry)
        for entry in own:
            self._work_out_constants(entry)
        for entry in own:
            try:
                with self._scopes.inside(entry.source):
                    if not generics_of(entry):  # Only what it is with certain values is a type.
                        self._declare(entry)
                        self._check_parts(entry)
            except Failed:
                continue
        self._names.check_pointers()
        if self._names.unknown_types:
            self._report_all_missing(own)
        for name, (address, source) in list(self._names.config_addresses.items()):
            if name[0] == ".":
                continue  # A list that TwinCAT 2 wrote may be out of date: the checker warns.
            del self._names.config_addresses[name]
            self._scopes.report(
                source, address.at, f"no variable '{name}' waits for an address", Code.BAD_ADDRESS
            )
        return Declarations(
            {key: entry.type for key, entry in self._scopes.entries.items() if _is_own(entry)},  # type: ignore[misc]
            {
                key: unit
                for key, unit in self._names.units.items()
                if issubclass(unit, GlobalVariables)
            },
            {key: unit for key, unit in self._names.units.items() if issubclass(unit, Program)},
            {entry.name.lower(): entry.tree for entry in every},
            self._names,
        )

    def _report_all_missing(self, own: Sequence[DeclaredUnit]) -> None:
        """Report the missing types of units that failed because of others, too."""
        from achse.st.missing.walk import MissingNames  # few need it

        for scope, spec in MissingNames(self._names, own).places:
            with suppress(Failed), self._scopes.inside(scope.source):
                self._names.named(spec, scope)

    def _declare(self, entry: DeclaredUnit) -> None:
        tree = entry.tree
        if isinstance(tree, TypeDeclaration | FunctionBlock | Interface):
            self._names.entry_type(entry, tree.at)
        elif isinstance(tree, GlobalList | ProgramTree):
            self._names.unit(entry)
        elif isinstance(tree, Function):
            self.check_inside(tree.blocks, tree.returns, self._scopes.scope(entry))

    # what is only checked --------------------------------------------------------------------

    def _check_parts(self, entry: DeclaredUnit) -> None:
        """Find what is wrong with methods and properties, of which no variables come."""
        parts: tuple[Part, ...] = getattr(entry.tree, "parts", ())
        scope = self._scopes.scope(entry)
        names: set[str] = set()
        for part in parts:
            if part.name.lower() in names:
                self._scopes.report(
                    entry.source,
                    part.at,
                    f"{entry.name} has two parts named {part.name}",
                    Code.DUPLICATE_NAME,
                )
            names.add(part.name.lower())
            if isinstance(part, Method):
                self.check_part(part, part.returns, scope, part.name)
            elif isinstance(part, Property):
                self.check_part(part.get, part.type, scope, part.name)
                self.check_part(part.set, None, scope, part.name)
        if isinstance(entry.tree, Interface):
            for base in entry.tree.extends:
                self._names.type_of(base, scope, entry.name)

    def check_part(
        self, part: Method | Accessor | None, returns: TypeSpec | None, scope: Scope, name: str
    ) -> None:
        blocks = () if part is None else part.blocks
        inside = Scope(scope.source, f"{scope.owner}.{name}", scope.space, scope)
        for block in blocks:
            for declaration in block.variables:
                for item in declaration.names:
                    inside.variables.setdefault(item.name.lower(), (block, declaration))
        self.check_inside(blocks, returns, inside)

    def check_inside(
        self, blocks: Iterable[VarBlock], returns: TypeSpec | None, scope: Scope
    ) -> None:
        try:
            with self._scopes.inside(scope.source):
                if returns is not None:
                    self._names.type_of(returns, scope, scope.owner)
                self._names.records.variables(blocks, scope)
        except Failed:
            pass

    # constants and addresses -----------------------------------------------------------------

    def _work_out_constants(self, entry: DeclaredUnit) -> None:
        """Evaluate constants in the order of declaration, so that long chains of them stay flat."""
        scope = self._scopes.scope(entry)
        for block in getattr(entry.tree, "blocks", ()):
            if "CONSTANT" not in block.qualifiers:
                continue
            for declaration in block.variables:
                name = declaration.names[0]
                if not isinstance(declaration.initial, Expression):
                    continue
                try:
                    self._names.constants.constant_of(
                        scope, (block, declaration), [name.name.lower()], name.at
                    )
                except (Failed, NotConstant, Unexpected):
                    # Reported already, or reported where the variable is made.
                    continue

    def _collect_addresses(self, entry: DeclaredUnit) -> None:
        """Collect the addresses that VAR_CONFIG gives to variables declared `AT %I*`."""
        for block in getattr(entry.tree, "blocks", ()):
            if block.section != "VAR_CONFIG":
                continue
            for declaration in block.variables:
                name, address = declaration.names[0], declaration.address
                if address is None:
                    self._scopes.report(
                        entry.source,
                        name.at,
                        "VAR_CONFIG gives an address: AT %…",
                        Code.BAD_ADDRESS,
                    )
                elif name.name[0] != "." and name.name.count(".") != 1:  # Else `MAIN.a`, `GVL.a`.
                    reach = "VAR_CONFIG reaches the variables of programs and lists only"
                    self._scopes.report(entry.source, name.at, reach, Code.BAD_ADDRESS)
                else:
                    self._names.config_addresses[name.name.lower()] = (address, entry.source)


def _is_own(entry: DeclaredUnit) -> bool:
    return entry.type is not None and not entry.is_library
