"""Declared types of paths in bodies, as far as names alone tell them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from achse.iec.derived import SubrangeType
from achse.iec.enums import EnumType
from achse.iec.names import ELEMENTARY
from achse.st.declared.scopes import DeclaredUnit, Scopes, with_bases
from achse.st.lint.uses import TrackedVariable
from achse.st.syntax.tree import (
    ArrayOf,
    Call,
    Declaration,
    Dereference,
    EnumOf,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    NamedType,
    PointerTo,
    ReferenceTo,
    StructOf,
    Subrange,
    This,
    TypeSpec,
    UnionOf,
)
from achse.st.syntax.units import (
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Program,
    Property,
    TypeDeclaration,
)

_MOST_ALIASES = 20
_OF_SEVERAL_CALLS = frozenset(
    ("ton", "tof", "tp", "lton", "ltof", "ltp", "r_trig", "f_trig", "ctu", "ctd", "ctud")
)
"""Blocks of the standard that compare a call with those before."""
_UNFINISHED = frozenset(("busy", "done", "active", "commandaborted"))
"""Outputs of blocks that work over several calls, apart from a `b` in front."""
_MOST_VALUES = 1_000
_MOST_TYPES = 1_000
"""Most types of members that are looked at for a default."""


class DeclaredType(NamedTuple):
    """A type as written, and the name space in which its names count."""

    spec: TypeSpec
    space: str


class CaseValues(NamedTuple):
    """All values of a type: numbers by their names, which of a range are the numbers themselves."""

    name: str
    """Of an enumeration; empty of a range."""
    numbers: Mapping[str, int]


class DeclaredTypes:
    """The types of variables and paths. `chain` is what a body sees, the nearest first."""

    def __init__(self, scopes: Scopes) -> None:
        self._scopes = scopes

    def unit_of(self, declared: DeclaredType | None) -> DeclaredUnit | None:
        """Return the unit that declares a type, behind aliases and references."""
        for _ in range(_MOST_ALIASES):
            if declared is None:
                return None
            spec = declared.spec
            if isinstance(spec, ReferenceTo):
                declared = DeclaredType(spec.target, declared.space)
                continue
            if not isinstance(spec, NamedType):
                return None
            entry = self._scopes.find(spec.name, declared.space)
            if entry is None:
                return None
            tree = entry.tree
            target = tree.type if isinstance(tree, TypeDeclaration) else None
            if not isinstance(target, NamedType) or target.name.lower() in ELEMENTARY:
                return entry
            declared = DeclaredType(target, entry.space)
        return None

    def may_be_block(self, declaration: Declaration, space: str) -> bool:
        """Return True if a variable is an instance of a function block, an array of them, or of a
        type that no source here declares."""
        if declaration.arguments:
            return True
        spec = _element(declaration.type)
        if not isinstance(spec, NamedType) or spec.name.lower() in ELEMENTARY:
            return False
        entry = self.unit_of(DeclaredType(spec, space))
        return entry is None or isinstance(entry.tree, FunctionBlock)

    def takes_several_calls(self, declaration: Declaration, space: str) -> bool:
        """Return True if a variable is an instance of a block, or an array of them, that is done
        after some calls: a timer, counter or edge, one that says so by an output, or one with such
        instances inside."""
        waiting, seen = [DeclaredType(_element(declaration.type), space)], set[str]()
        while waiting and len(seen) < _MOST_TYPES:
            entry = self._block(waiting.pop())
            if entry is None or entry.name.lower() in seen:
                continue
            seen.add(entry.name.lower())
            tree = entry.tree
            assert isinstance(tree, FunctionBlock)
            if entry.name.lower() in _OF_SEVERAL_CALLS:
                return True
            for block in tree.blocks:
                for item in block.variables:
                    names = {one.name.lower().removeprefix("b") for one in item.names}
                    if block.section == "VAR_OUTPUT" and not names.isdisjoint(_UNFINISHED):
                        return True
                    waiting.append(DeclaredType(_element(item.type), entry.space))
            if tree.extends is not None:
                waiting.append(DeclaredType(tree.extends, entry.space))
        return False

    def _block(self, type: DeclaredType) -> DeclaredUnit | None:
        """Return the function block that a type is; None of others."""
        entry = self.unit_of(type) if isinstance(type.spec, NamedType) else None
        return entry if entry is not None and isinstance(entry.tree, FunctionBlock) else None

    def has_default(self, declaration: Declaration, space: str) -> bool:
        """Return True if the type of a variable begins with another value than 0."""
        waiting = [DeclaredType(_element(declaration.type), space)]
        for _ in range(_MOST_TYPES):
            if not waiting:
                return False
            spec, here = waiting.pop()
            if isinstance(spec, StructOf | UnionOf):
                if any(member.initial is not None for member in spec.members):
                    return True
                waiting += [DeclaredType(_element(member.type), here) for member in spec.members]
            elif isinstance(spec, NamedType) and spec.name.lower() not in ELEMENTARY:
                entry = self._scopes.find(spec.name, here)
                tree = None if entry is None else entry.tree
                if entry is not None and isinstance(tree, TypeDeclaration):
                    if tree.initial is not None or _begins_above_zero(entry.type):
                        return True
                    waiting.append(DeclaredType(_element(tree.type), entry.space))
                    if tree.extends is not None:
                        waiting.append(DeclaredType(tree.extends, entry.space))
        return True  # too many to look at

    def values_of(
        self, path: Expression, chain: Sequence[Mapping[str, TrackedVariable]], unit: DeclaredUnit
    ) -> CaseValues | None:
        """Return the values that a path can have in a body of a unit: those of an enumeration or of
        a short range. None if there are more, or if its declaration does not tell them."""
        declared = self.type_of(path, chain, unit)
        if declared is not None and isinstance(declared.spec, EnumOf):
            return _values_in(declared.spec)
        if declared is not None and isinstance(declared.spec, Subrange):
            limits = declared.spec.limits
            return _values_between(_number(limits.low), _number(limits.high))
        entry = self.unit_of(declared)
        type = None if entry is None else entry.type
        if isinstance(type, EnumType):
            return CaseValues(type.name, type.numbers)
        return _values_between(type.low, type.high) if isinstance(type, SubrangeType) else None

    def type_of(
        self, path: Expression, chain: Sequence[Mapping[str, TrackedVariable]], unit: DeclaredUnit
    ) -> DeclaredType | None:
        """Return the declared type of a path; None if it takes more than names to know it."""
        steps: list[Expression] = []
        while isinstance(path, Member | Index | Dereference | Call):
            steps.append(path)
            path = path.of
        declared: DeclaredType | None = None
        if isinstance(path, This) and len(steps) > 1 and isinstance(steps[-1], Dereference):
            steps.pop()
            member = steps.pop()
            declared = self._variable(unit, member.name) if isinstance(member, Member) else None
        elif isinstance(path, Name | GlobalName):
            declared = self._root(path, chain, unit)
            first = steps[-1] if steps else None
            if declared is None and isinstance(path, Name) and isinstance(first, Member):
                entry = self._scopes.find(path.name, unit.space)
                if entry is not None and isinstance(entry.tree, GlobalList | Program):
                    declared = self._variable(entry, first.name)
                    steps.pop()
        for step in reversed(steps):
            declared = self._step(declared, step)
        return declared

    def _root(
        self,
        path: Name | GlobalName,
        chain: Sequence[Mapping[str, TrackedVariable]],
        unit: DeclaredUnit,
    ) -> DeclaredType | None:
        key = path.name.lower()
        for variables in chain if isinstance(path, Name) else ():
            variable = variables.get(key)
            if variable is not None:
                return DeclaredType(variable.declaration.type, variable.entry.space)
        own = next(self._parts(unit, key), None) if isinstance(path, Name) else None
        if own is not None:
            return own
        lists = self._scopes.globals.get(key, ())
        if len(lists) == 1:
            return self._variable(lists[0], key)
        entry = self._scopes.find(path.name, unit.space)
        tree = None if entry is None else entry.tree
        if entry is None or not isinstance(tree, Function) or tree.returns is None:
            return None
        return DeclaredType(tree.returns, entry.space)

    def _step(self, declared: DeclaredType | None, step: Expression) -> DeclaredType | None:
        if declared is None or isinstance(step, Call):  # a routine has the type that it returns
            return declared
        if isinstance(step, Member):
            entry = self.unit_of(declared)
            return None if entry is None else self._variable(entry, step.name)
        spec = declared.spec
        while isinstance(spec, ReferenceTo):
            spec = spec.target
        if isinstance(step, Index) and isinstance(spec, ArrayOf):
            return DeclaredType(spec.element, declared.space)
        if isinstance(step, Dereference | Index) and isinstance(spec, PointerTo):
            return DeclaredType(spec.target, declared.space)
        return None

    def _variable(self, entry: DeclaredUnit, name: str) -> DeclaredType | None:
        """Return the type of a variable, property or method of a unit."""
        key = name.lower()
        return next(self._declared(entry, key), None) or next(self._parts(entry, key), None)

    def _declared(self, entry: DeclaredUnit, key: str) -> Iterator[DeclaredType]:
        for scope in with_bases(self._scopes.scope(entry)):
            if key in scope.variables:
                yield DeclaredType(scope.variables[key][1].type, scope.space)

    def _parts(self, entry: DeclaredUnit, key: str) -> Iterator[DeclaredType]:
        """Yield the types of properties, and of what methods return, of that name: of the unit
        first, then of its bases."""
        seen: set[int] = set()
        waiting = [entry]
        while waiting:
            unit = waiting.pop(0)
            tree = unit.tree
            if id(unit) in seen or not isinstance(tree, FunctionBlock | Interface):
                continue
            seen.add(id(unit))
            for part in tree.parts:
                spec = part.type if isinstance(part, Property) else getattr(part, "returns", None)
                if part.name.lower() == key and spec is not None:
                    yield DeclaredType(spec, unit.space)
            bases = tree.extends if isinstance(tree, Interface) else (tree.extends,)
            units = (self._scopes.find(base.name, unit.space) for base in bases if base is not None)
            waiting += [base for base in units if base is not None]


def _begins_above_zero(type: object) -> bool:
    """Return True if the first value of an enumeration is not 0."""
    return isinstance(type, EnumType) and next(iter(type.numbers.values()), 0) != 0


def _element(spec: TypeSpec) -> TypeSpec:
    """Return the type of the elements of an array, of whatever depth; other types as they are."""
    while isinstance(spec, ArrayOf):
        spec = spec.element
    return spec


def _values_in(spec: EnumOf) -> CaseValues | None:
    """Return the values of an enumeration where a variable is declared; None if other constants
    tell its numbers."""
    numbers: dict[str, int] = {}
    following = 0
    for item in spec.values:
        number = following if item.value is None else _number(item.value)
        if number is None:
            return None
        numbers[item.name] = number
        following = number + 1
    return CaseValues("its values", numbers)


def _values_between(low: int | None, high: int | None) -> CaseValues | None:
    if low is None or high is None or high - low >= _MOST_VALUES:
        return None
    return CaseValues("", {str(number): number for number in range(low, high + 1)})


def _number(tree: Expression) -> int | None:
    """Return the number that is written; None of another constant."""
    if isinstance(tree, Literal) and tree.kind == "integer" and tree.text.isdecimal():
        return int(tree.text)
    return None
