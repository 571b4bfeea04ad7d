"""Names: what is declared where, and the constants that names stand for.

Source: IEC 61131-3 (2013) tables 11 and 13.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar

from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, ReferenceType, resolved
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.constants import Evaluator, Path, path_of
from achse.st.cursor import Unexpected
from achse.st.given import GivenTypes
from achse.st.parser import Parsed
from achse.st.source import Fault, Source
from achse.st.tree import (
    ArrayInitial,
    Declaration,
    Dereference,
    EnumOf,
    Expression,
    Index,
    Literal,
    Member,
    NamedType,
    Note,
    StructInitial,
    TypeOperand,
    TypeSpec,
    VarBlock,
)
from achse.st.units import (
    FunctionBlock,
    GlobalList,
    Namespace,
    Program,
    Property,
    TypeDeclaration,
    Unit,
)
from achse.st.values import Constant, NotConstant, fitted

__all__ = ["DEEPEST", "Entry", "Failed", "Scope", "Scopes", "attributes_of"]

T = TypeVar("T")

DEEPEST = 64
"""How deep types and constants that are declared elsewhere may rest on each other."""


class Failed(Exception):
    """Something needed is at fault itself; that was reported in its place."""


@dataclass(slots=True, eq=False)
class Entry:
    """A declared unit: `name` with its name space, and the type made of it once it is."""

    name: str
    tree: Unit
    source: Source
    space: str
    is_library: bool
    building: bool = False
    failed: bool = False
    type: IecType[Any] | None = None


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
    constants: dict[str, Constant | None] = field(default_factory=dict)
    """Those worked out already; None while one is."""
    failed: set[str] = field(default_factory=set)
    """Constants at fault, which is told."""


def _with_bases(scope: Scope) -> Iterator[Scope]:
    """A scope and those of the blocks it extends, which faulty sources may close to a ring."""
    seen: set[int] = set()
    here: Scope | None = scope
    while here is not None and id(here) not in seen:
        yield here
        seen.add(id(here))
        here = here.base


def attributes_of(note: Note) -> dict[str, str]:
    """Attributes by name; the one that decides a layout in its usual spelling."""
    if not note.attributes:
        return {}
    return {
        name.lower() if name.lower() == "pack_mode" else name: value
        for name, value in note.attributes
    }


class Scopes:
    """Everything declared, by name and without case; faults are collected in `faults`."""

    def __init__(self, constants: Mapping[str, object], given: GivenTypes) -> None:
        self.given = given
        self.faults: dict[Fault, None] = {}
        self.entries: dict[str, Entry] = {}
        self._given_constants = {name.lower(): value for name, value in constants.items()}
        self.globals: dict[str, list[tuple[Scope, Declared]]] = {}
        """Variables that need no list in front, by name in lower case."""
        self.loose_values: dict[str, list[Entry]] = {}
        """Enumerations by the values that need no type in front."""
        self._scopes: dict[int, Scope] = {}
        self._depth = 0

    # what is declared ----------------------------------------------------------------------

    def add(self, sources: Iterable[Parsed], *, is_library: bool = False) -> None:
        """Take in the units of sources. What a library declares gives way to the user's own."""
        for parsed in sources:
            for unit in parsed.units:
                self._add(unit, parsed.source, "", is_library)

    def _add(self, unit: Unit, source: Source, space: str, is_library: bool) -> None:
        name = f"{space}.{unit.name}" if space else unit.name
        if isinstance(unit, Namespace):
            for inner in unit.units:
                self._add(inner, source, name, is_library)
            return
        known = self.entries.get(name.lower())
        if known is not None:
            if not is_library:
                first = known.source.locate(known.tree.at)
                self.report(source, unit.at, f"{name} is declared already, at {first}")
            return
        if unit.name.startswith("__"):
            self.report(source, unit.at, "names with two underscores in front are reserved")
            return
        entry = Entry(name, unit, source, space, is_library)
        self.entries[name.lower()] = entry
        if "qualified_only" in {key.lower() for key, _ in unit.note.attributes}:
            return
        if isinstance(unit, GlobalList):
            scope = self.scope(entry)
            for key, declared in scope.variables.items():
                self.globals.setdefault(key, []).append((scope, declared))
        elif isinstance(unit, TypeDeclaration) and isinstance(unit.type, EnumOf):
            for value in unit.type.values:
                self.loose_values.setdefault(value.name.lower(), []).append(entry)

    def find(self, name: str, space: str = "") -> Entry | None:
        """The unit of a name as seen from a name space. Names of libraries in front of it that
        nothing here declares are passed over: `Tc2_MC2.AXIS_REF` is AXIS_REF."""
        key = name.lower()
        prefix = space.lower()
        while prefix:
            if found := self.entries.get(f"{prefix}.{key}"):
                return found
            prefix = prefix.rpartition(".")[0]
        while True:
            if found := self.entries.get(key):
                return found
            _, dot, key = key.partition(".")
            if not dot:
                return None

    def scope(self, entry: Entry) -> Scope:
        """What the inside of a unit sees."""
        found = self._scopes.get(id(entry))
        if found is None:
            found = Scope(entry.source, entry.name, entry.space)
            self._scopes[id(entry)] = found
            tree = entry.tree
            if isinstance(tree, FunctionBlock) and tree.extends is not None:
                base = self.find(tree.extends.name, entry.space)
                if base is not None and isinstance(base.tree, FunctionBlock):
                    found.base = self.scope(base)
                elif base is None:
                    found.extends = tree.extends
            for block in getattr(tree, "blocks", ()):
                for declaration in block.variables:
                    for item in declaration.names:
                        found.variables.setdefault(item.name.lower(), (block, declaration))
        return found

    # faults --------------------------------------------------------------------------------

    def report(self, source: Source, at: int, message: str) -> None:
        """Keep a fault; what is asked for twice is told once."""
        self.faults.setdefault(source.fault(at, message))

    @contextmanager
    def inside(self, source: Source) -> Iterator[None]:
        """Report what goes wrong inside as a fault of this source, and raise `Failed`."""
        self._depth += 1
        try:
            yield
        except Unexpected as fault:
            self.report(source, fault.at, fault.message)
            raise Failed from None
        finally:
            self._depth -= 1

    @contextmanager
    def deeper(self) -> Iterator[None]:
        """One level deeper, without another source."""
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    def check_depth(self, at: int) -> None:
        """Raise `Unexpected` if declarations rest on each other too deep."""
        if self._depth > DEEPEST:
            raise Unexpected(at, f"declarations rest on each other more than {DEEPEST} deep")

    @staticmethod
    def made(make: Callable[[], T], at: int) -> T:
        """What `make` gives; an error of the type system as one of the source."""
        try:
            return make()
        except IecError as error:
            raise Unexpected(at, str(error)) from None

    # types, known one floor up ---------------------------------------------------------------

    def type_of(self, spec: TypeSpec, scope: Scope, hint: str) -> IecType[Any]:
        """The type of a specification; `hint` names it if it has no name."""
        raise NotImplementedError

    def entry_type(self, entry: Entry, at: int) -> IecType[Any]:
        """The type that a unit declares."""
        raise NotImplementedError

    def has_property(self, block: str, name: str) -> bool:
        """Whether a function block of that name, or its base, has that PROPERTY."""
        entry = self.find(block.partition("<")[0])
        while entry is not None and isinstance(tree := entry.tree, FunctionBlock):
            if any(isinstance(p, Property) and p.name.lower() == name.lower() for p in tree.parts):
                return True
            base = tree.extends
            entry = None if base is None else self.find(base.name, entry.space)
        return False

    # constants -----------------------------------------------------------------------------

    def evaluator(
        self, scope: Scope, otherwise: Callable[[Expression], Constant] | None = None
    ) -> Evaluator:
        """Works out expressions as the inside of `scope` sees them."""
        names = (
            lambda path, at: self._lookup(path, at, scope),
            lambda operand: self._operand_type(operand, scope),
        )
        return Evaluator(*names) if otherwise is None else Evaluator(*names, otherwise)

    def constant(self, tree: Expression, scope: Scope) -> Constant:
        """The value of an expression. Raises `NotConstant`, `Unexpected`, `Failed`."""
        return self.evaluator(scope).value(tree)

    def check_names(self, tree: Expression, scope: Scope) -> None:
        """Raise `Unexpected` if a name in an expression means nothing."""
        with suppress(NotConstant):
            self.constant(tree, scope)

    def integer(self, tree: Expression, scope: Scope, what: str) -> int:
        """The whole number that an expression is. Raises `Unexpected`, `Failed`."""
        if isinstance(tree, Literal) and tree.text.isdecimal() and len(tree.text) < 20:
            return int(tree.text)
        return self.evaluator(scope).integer(tree, what, tree.at)

    def _lookup(self, path: Path, at: int, scope: Scope) -> Constant:
        keys = [part.lower() for part in path]
        if len(keys) == 1 and keys[0] in scope.values:
            return scope.values[keys[0]]
        own = self.own(keys[0], scope)
        if own is not None and not (len(keys) == 2 and self._is_enum(keys[0], scope.space)):
            return self.constant_of(*own, keys, at)
        if self.is_inherited(keys[0], scope):
            raise NotConstant(at)
        if len(keys) == 1:
            return self.global_constant(keys[0], path[0], at)
        if (found := self._qualified(keys, scope.space, at)) is not None:
            return found
        if keys[0] in self.globals:
            raise NotConstant(at)
        if keys[-1] in self._given_constants:
            return self._given_constant(keys[-1], at)
        if len(keys) > 1 and (keys[-1] in self.globals or keys[-1] in self.loose_values):
            # The name of a library in front, which nothing here declares.
            return self.global_constant(keys[-1], path[-1], at)
        raise Unexpected(at, f"no constant or variable is named '{'.'.join(path)[:80]}'")

    def variable(self, path: Path, scope: Scope) -> tuple[Scope, list[str]] | None:
        """Where the variable is declared that a path begins with, and the names from it on."""
        keys = [part.lower() for part in path]
        if (own := self.own(keys[0], scope)) is not None:
            return own[0], keys
        for cut in range(1, len(keys)):
            entry = self.find(".".join(keys[:cut]), scope.space)
            if entry is not None and keys[cut] in self.scope(entry).variables:
                return self.scope(entry), keys[cut:]
        if found := self.globals.get(keys[0]):
            return found[0][0], keys
        return None

    def is_placed(self, scope: Scope) -> bool:
        """Whether the variables of a scope are those of a list or a program: there once."""
        entry = self.entries.get(scope.owner.lower())
        return entry is not None and isinstance(entry.tree, GlobalList | Program)

    def _is_enum(self, name: str, space: str) -> bool:
        """Whether `State.Idle` means a value, though a variable is called `State` like its type."""
        entry = self.find(name, space)
        tree = None if entry is None else entry.tree
        return isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf | NamedType)

    def own(self, key: str, scope: Scope) -> tuple[Scope, Declared] | None:
        """The variable of that name in a scope or in those it extends."""
        for here in _with_bases(scope):
            if key in here.variables:
                return here, here.variables[key]
        return None

    def is_inherited(self, key: str, scope: Scope) -> bool:
        """Whether a variable comes from a base that no source declares."""
        for here in _with_bases(scope):
            if here.extends is not None:
                base = self.given.find(here.extends.name, here.extends.at)
                return isinstance(base, StructType) and base.has_member(key)
        return False

    def global_constant(self, key: str, name: str, at: int) -> Constant:
        """The constant that a name means where nothing nearer has it. Raises `NotConstant`."""
        found = self.globals.get(key, ())
        if len(found) > 1:
            places = " and ".join(scope.owner for scope, _ in found[:3])
            raise Unexpected(at, f"'{name}' is declared in {places}: which one is meant?")
        if found:
            return self.constant_of(*found[0], [key], at)
        values = self.loose_values.get(key, ())
        if len(values) > 1:
            places = " and ".join(entry.name for entry in values[:3])
            raise Unexpected(at, f"'{name}' is a value of {places}: which one is meant?")
        if values:
            return self._enum_value(values[0], key, at)
        if key in self._given_constants:
            return self._given_constant(key, at)
        if key in self.entries:
            raise NotConstant(at)
        further = self.given.values(key)
        if len(further) > 1:
            places = " and ".join(item.type.name for item in further[:3] if item.type)
            raise Unexpected(at, f"'{name}' is a value of {places}: which one is meant?")
        if further:
            return further[0]
        raise Unexpected(at, f"no constant or variable is named '{name[:80]}'")

    def _qualified(self, keys: list[str], space: str, at: int) -> Constant | None:
        """`GVL.cMax`, `E_State.Idle`, `MAIN.nCount`, with name spaces in front."""
        for cut in range(1, len(keys)):
            name = ".".join(keys[:cut])
            entry = self.find(name, space)
            if entry is None:
                given = self.given.find(name, at)
                if given is not None and isinstance(given := resolved(given), EnumType):
                    return self._member(given, keys[cut], at)
            elif isinstance(entry.tree, TypeDeclaration):
                return self._enum_value(entry, keys[cut], at)
            else:
                scope = self.scope(entry)
                if keys[cut] not in scope.variables:
                    raise Unexpected(at, f"{entry.name} has no variable '{keys[cut][:80]}'")
                return self.constant_of(scope, scope.variables[keys[cut]], keys[cut:], at)
        return None

    def _enum_value(self, entry: Entry, key: str, at: int) -> Constant:
        type = resolved(self.entry_type(entry, at))
        if not isinstance(type, EnumType):
            raise Unexpected(at, f"{entry.name} is no enumeration")
        return self._member(type, key, at)

    def _member(self, type: EnumType[Any], key: str, at: int) -> Constant:
        for name, number in type.numbers.items():
            if name.lower() == key:
                return Constant(number, type)
        raise Unexpected(at, f"{type.name} has no value '{key[:80]}'")

    def _given_constant(self, key: str, at: int) -> Constant:
        value = self._given_constants[key]
        if not isinstance(value, int | float | str):
            raise NotConstant(at)
        return Constant(value)

    def constant_of(self, scope: Scope, declared: Declared, keys: list[str], at: int) -> Constant:
        """The value of a constant. Raises `NotConstant` for other variables, and `Failed`."""
        block, declaration = declared
        initial = declaration.initial
        key = keys[0]
        if len(keys) == 1 and (known := scope.constants.get(key)) is not None:
            return known
        # What a constant structure or array holds is left to run time, like a variable.
        if "CONSTANT" not in block.qualifiers or len(keys) > 1:
            raise NotConstant(at)
        if initial is None or isinstance(initial, ArrayInitial | StructInitial):
            raise NotConstant(at)
        if key in scope.failed:
            raise Failed
        if key not in scope.constants:
            self.check_depth(at)
            scope.constants[key] = None
            try:
                with self.inside(scope.source):
                    scope.constants[key] = self._worked_out(declaration, initial, scope)
            except Failed:
                scope.failed.add(key)
                raise
            finally:
                if scope.constants[key] is None:
                    del scope.constants[key]
        found = scope.constants[key]
        if found is None:
            raise Unexpected(at, f"the constant '{key}' rests on itself")
        return found

    def _worked_out(self, declaration: Declaration, initial: Expression, scope: Scope) -> Constant:
        hint = f"{scope.owner}.{declaration.names[0].name}"
        type = self.type_of(declaration.type, scope, hint)
        constant = self.constant(initial, scope)
        value = fitted(constant, type, initial.at)
        assert isinstance(value, int | float | str)
        return Constant(value, type)

    def _operand_type(self, operand: Expression, scope: Scope) -> IecType[Any]:
        """The type that SIZEOF and the like look at: one that is named, or that of a variable."""
        at = operand.at
        if isinstance(operand, TypeOperand):
            return self.type_of(operand.type, scope, scope.owner)
        if isinstance(operand, Index):
            whole = resolved(self._operand_type(operand.of, scope))
            if not isinstance(whole, ArrayType):
                raise Unexpected(at, f"{whole.name} is no array")
            return whole.element
        if isinstance(operand, Dereference):
            pointer = resolved(self._operand_type(operand.of, scope))
            if not isinstance(pointer, PointerType):
                raise Unexpected(at, f"{pointer.name} is no pointer: ^ leads nowhere")
            return pointer.target
        path = path_of(operand)
        if path is None and isinstance(operand, Member):
            return self._member_type(self._operand_type(operand.of, scope), operand.name, at)
        if path is None:
            raise NotConstant(at)
        if (found := self.variable(path, scope)) is not None:
            owner, rest = found
            self.check_depth(at)
            with self.inside(owner.source):
                declared = owner.variables[rest[0]][1]
                type = self.type_of(declared.type, owner, f"{owner.owner}.{rest[0]}")
            for name in rest[1:]:
                type = self._member_type(type, name, at)
            return type
        name = ".".join(path)
        given = self.given.find(name, at)
        if given is not None:
            return given
        entry = self.find(name, scope.space)
        if entry is not None and isinstance(entry.tree, TypeDeclaration | FunctionBlock):
            return self.entry_type(entry, at)
        raise NotConstant(at)

    def _member_type(self, whole: IecType[Any], name: str, at: int) -> IecType[Any]:
        real = resolved(whole)
        if isinstance(real, ReferenceType):
            real = resolved(real.target)
        if not isinstance(real, StructType):
            raise Unexpected(at, f"{whole.name} has no members")
        return self.made(lambda: real.member(name).type, at)
