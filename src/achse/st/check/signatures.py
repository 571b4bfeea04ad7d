"""Signatures: what a routine is called with and keeps, without its body."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from achse.iec.derived import ReferenceType
from achse.iec.elementary import DINT
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.st.check.frames import VariableFrame
from achse.st.declared.records import bound_names, instance_member
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed, Scope, with_bases
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import NO_NOTE, Declaration, Initial, Name, TypeSpec, VarBlock
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import (
    Accessor,
    Action,
    Body,
    Function,
    FunctionBlock,
    Interface,
    Method,
    Program,
    Property,
    Unit,
)
from achse.st.typed.places import StaticBase
from achse.st.typed.project import RoutineKind

SignatureTree: TypeAlias = Function | FunctionBlock | Program | Method | Accessor | Action

_PARAMETERS = ("VAR_INPUT", "VAR_IN_OUT", "VAR_OUTPUT")
_LOCALS = ("VAR", "VAR_TEMP")


@dataclass(slots=True, eq=False)
class DeclaredParameter:
    """A parameter as it is declared."""

    variable: Variable[Any, Any]
    """Variable in the frame, or in the record of a block or program."""
    section: str
    """VAR_INPUT, VAR_OUTPUT or VAR_IN_OUT."""
    type: IecType[Any]
    """Declared type; for a VAR_IN_OUT the type of its target."""
    is_constant: bool = False
    """VAR_IN_OUT CONSTANT, which takes values, too."""
    bounds: tuple[Variable[Any, Any], ...] = ()
    """Hidden variables for the lower and upper bound of each dimension of an ARRAY [*]."""
    has_initial: bool = False
    is_plain: bool | None = None
    """True if an argument is only converted and stored; None before the first call."""


@dataclass(slots=True, eq=False)
class Signature:
    """A routine without its body."""

    key: str
    name: str
    kind: RoutineKind
    entry: DeclaredUnit
    """The unit it belongs to."""
    tree: SignatureTree
    scope: Scope
    frame: VariableFrame
    this: StructType[Any] | None
    parameters: list[DeclaredParameter] = field(default_factory=list)
    result: Variable[Any, Any] | None = None
    nothing: Variable[Any, Any] | None = None
    """A hidden BOOL, where something takes the value of a function that gives none."""
    statics: dict[str, StaticBase] = field(default_factory=dict)
    members: dict[str, str] = field(default_factory=dict)
    """VAR_INST variables: their names in the record of the block."""
    starts: list[tuple[Declaration, Variable[Any, Any]]] = field(default_factory=list)
    """Locals whose first value takes code."""
    accessor_of: Property | None = None
    _by_name: dict[str, DeclaredParameter] = field(default_factory=dict)

    @property
    def source(self) -> Source:
        return self.entry.source

    @property
    def body(self) -> Body:
        return self.tree.body

    @property
    def modifiers(self) -> tuple[str, ...]:
        own: tuple[str, ...] = getattr(self.tree, "modifiers", ())
        return own if self.accessor_of is None else own + self.accessor_of.modifiers

    @property
    def is_abstract(self) -> bool:
        return "ABSTRACT" in self.modifiers or isinstance(self.entry.tree, Interface)

    @property
    def by_name(self) -> dict[str, DeclaredParameter]:
        """The parameters in order, by name in lower case."""
        if len(self._by_name) < len(self.parameters):
            self._by_name = parameters_by_name(self.parameters)
        return self._by_name

    def parameter(self, key: str) -> DeclaredParameter | None:
        """Return the parameter of that name, in lower case."""
        return self.by_name.get(key)


def parameters_by_name(parameters: Iterable[DeclaredParameter]) -> dict[str, DeclaredParameter]:
    """Return parameters by name in lower case."""
    return {item.variable.name.lower(): item for item in parameters}


class Routines:
    """Makes signatures, each at its first request."""

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self._signature_by_key: dict[str, Signature | None] = {}
        self._outdated: dict[str, Signature] = {}
        """Signatures to make again when they are asked for."""

    def of_function(self, entry: DeclaredUnit) -> Signature:
        """Return a function. Raises `Failed`."""
        tree = entry.tree
        assert isinstance(tree, Function)
        scope = self._names.scopes.scope(entry)
        return self._create(
            entry.name, RoutineKind.FUNCTION, entry, tree, scope, None, tree.returns, tree.name
        )

    def of_body(self, entry: DeclaredUnit) -> Signature:
        """Return the body of a function block or program. Raises `Failed`."""
        tree = entry.tree
        assert isinstance(tree, FunctionBlock | Program)
        kind = RoutineKind.BODY if isinstance(tree, FunctionBlock) else RoutineKind.PROGRAM
        scope = self._names.scopes.scope(entry)
        return self._create(entry.name, kind, entry, tree, scope, self.this(entry), None, "")

    def of_method(self, entry: DeclaredUnit, tree: Method) -> Signature:
        """Return a method of a block, program or interface. Raises `Failed`."""
        name = f"{entry.name}.{tree.name}"
        scope = self._inside(entry, name, tree.blocks)
        kind = RoutineKind.METHOD
        this = self.this(entry)
        return self._create(name, kind, entry, tree, scope, this, tree.returns, tree.name)

    def of_action(self, entry: DeclaredUnit, tree: Action) -> Signature:
        """Return an action. Raises `Failed`."""
        name = f"{entry.name}.{tree.name}"
        scope = self._inside(entry, name, ())
        return self._create(
            name, RoutineKind.ACTION, entry, tree, scope, self.this(entry), None, ""
        )

    def of_accessor(self, entry: DeclaredUnit, tree: Property, *, get: bool) -> Signature | None:
        """GET or SET of a property; None if it has none. Raises `Failed`."""
        accessor = tree.get if get else tree.set
        if accessor is None:
            return None
        name = f"{entry.name}.{'__get' if get else '__set'}{tree.name}"
        known = self._signature_by_key.get(name.lower())
        if known is not None:
            return known
        scope = self._inside(entry, name, accessor.blocks)
        kind = RoutineKind.GET if get else RoutineKind.SET
        returns = tree.type if get else None
        this = self.this(entry)
        signature = self._create(name, kind, entry, accessor, scope, this, returns, tree.name, tree)
        signature.accessor_of = tree
        return signature

    def made_again(self, known: Signature) -> Signature:
        """Return the signature of a routine once more, with an empty frame. Raises `Failed`."""
        self._signature_by_key.pop(known.key, None)
        entry, tree = known.entry, known.tree
        match known.kind:
            case RoutineKind.FUNCTION:
                return self.of_function(entry)
            case RoutineKind.BODY | RoutineKind.PROGRAM:
                return self.of_body(entry)
            case RoutineKind.METHOD:
                assert isinstance(tree, Method)
                return self.of_method(entry, tree)
            case RoutineKind.ACTION:
                assert isinstance(tree, Action)
                return self.of_action(entry, tree)
        owner = known.accessor_of
        assert owner is not None
        signature = self.of_accessor(entry, owner, get=known.kind is RoutineKind.GET)
        assert signature is not None
        return signature

    def forget(self, is_touched: Callable[[DeclaredUnit], bool]) -> None:
        """Forget the signatures in units that were declared again, and those that failed."""
        self._outdated = {
            key: one for key, one in self._outdated.items() if not is_touched(one.entry)
        }
        self._signature_by_key = {
            key: one
            for key, one in self._signature_by_key.items()
            if one is not None and not is_touched(one.entry)
        }

    def outdate(self, signatures: Iterable[Signature]) -> None:
        """Make signatures again, when they are asked for, of trees that are theirs now."""
        self._outdated |= {one.key: one for one in signatures}
        for key in self._outdated:
            self._signature_by_key.pop(key, None)

    def is_outdated(self, key: str) -> bool:
        """Return True if a signature is to be made again before it is asked for."""
        return key in self._outdated

    @property
    def created(self) -> list[Signature]:
        """The signatures so far, those too that are to be made again."""
        current = [one for one in self._signature_by_key.values() if one is not None]
        return current + list(self._outdated.values())

    def known(self, key: str) -> Signature | None:
        """Return the signature of that key, if it was requested."""
        signature = self._signature_by_key.get(key)
        if signature is None and key in self._outdated:
            return self.made_again(self._outdated[key])
        return signature

    def entry(self, key: str) -> DeclaredUnit | None:
        """Return the unit of the signature of that key, if it was requested."""
        signature = self._signature_by_key.get(key) or self._outdated.get(key)
        return None if signature is None else signature.entry

    def this(self, entry: DeclaredUnit) -> StructType[Any] | None:
        """Return the record of the instances that routines of a unit run on. Raises `Failed`."""
        if isinstance(entry.tree, FunctionBlock):
            type = self._names.entry_type(entry, entry.tree.at)
            assert isinstance(type, StructType)
            return type
        return None

    def _inside(self, entry: DeclaredUnit, name: str, blocks: Iterable[VarBlock]) -> Scope:
        outer = self._names.scopes.scope(entry)
        scope = Scope(entry.source, name, entry.space, outer)
        for block in blocks:
            for declaration in block.variables:
                for item in declaration.names:
                    scope.variables.setdefault(item.name.lower(), (block, declaration))
        return scope

    # frames ----------------------------------------------------------------------------------

    def _create(
        self,
        name: str,
        kind: RoutineKind,
        entry: DeclaredUnit,
        tree: SignatureTree,
        scope: Scope,
        this: StructType[Any] | None,
        returns: TypeSpec | None,
        result: str,
        property: Property | None = None,
    ) -> Signature:
        key = name.lower()
        if key in self._signature_by_key:
            known = self._signature_by_key[key]
            if known is None:
                raise Failed
            return known
        self._signature_by_key[key] = None
        self._outdated.pop(key, None)
        frame = VariableFrame(name, self._names.rules)
        signature = Signature(key, name, kind, entry, tree, scope, frame, this)
        with self._names.scopes.inside(entry.source):
            if returns is not None:
                initial = None if property is None else property.initial
                signature.result = self._result(signature, returns, result, initial)
            if kind is RoutineKind.SET and property is not None:
                type = self._names.type_of(property.type, scope, name)
                value = frame.add(Variable(type, name=property.name, section=Section.INPUT))
                signature.parameters.append(DeclaredParameter(value, "VAR_INPUT", type))
            self._fill(signature, tuple(getattr(tree, "blocks", ())))
        self._signature_by_key[key] = signature
        return signature

    def _result(
        self, signature: Signature, returns: TypeSpec, name: str, initial: Initial | None
    ) -> Variable[Any, Any]:
        """Return the variable that a routine's result is in, at its first value."""
        if initial is None:
            type = self._names.type_of(returns, signature.scope, signature.name)
            return signature.frame.add(Variable(type, name=name, section=Section.OUTPUT))
        named = (Name(name, initial.at),)
        declaration = Declaration(named, None, returns, (), initial, NO_NOTE)
        block = VarBlock("VAR_OUTPUT", (), (declaration,), NO_NOTE, initial.at)
        ((variable, _),) = self._names.records.declared(block, declaration, signature.scope)
        placed = signature.frame.add(variable)
        if placed.start_values:
            signature.starts.append((declaration, placed))
        return placed

    def _fill(self, signature: Signature, blocks: tuple[VarBlock, ...]) -> None:
        """Put the variables of a routine where they belong."""
        in_record = signature.kind in (RoutineKind.BODY, RoutineKind.PROGRAM)
        if in_record:
            self._parameters_of_record(signature)
        else:
            for block in blocks:
                if block.section in _PARAMETERS:
                    for declaration in block.variables:
                        self._parameter(signature, block, declaration)
        for block in blocks:
            for declaration in block.variables:
                self._local(signature, block, declaration, in_record)

    def _local(
        self, signature: Signature, block: VarBlock, declaration: Declaration, in_record: bool
    ) -> None:
        names = self._names
        section = block.section
        if in_record and section != "VAR_TEMP":
            return
        if section == "VAR_INST" and signature.this is not None:
            method = signature.name.rpartition(".")[2]
            for item in declaration.names:
                signature.members[item.name.lower()] = instance_member(
                    signature.this, method, item.name
                )
            return
        if section in ("VAR_STAT", "VAR_INST") or (
            section in _LOCALS and "CONSTANT" in block.qualifiers
        ):
            for variable, _ in names.records.declared(block, declaration, signature.scope):
                base = StaticBase(signature.name, variable)
                signature.statics[variable.name.lower()] = base
            return
        if section not in _LOCALS:
            return
        for variable, at in names.records.declared(block, declaration, signature.scope):
            if signature.frame.find(variable.name.lower()) is not None:
                raise Unexpected(
                    at,
                    f"{signature.name} has two variables named {variable.name}",
                    Code.DUPLICATE_NAME,
                )
            placed = signature.frame.add(variable)
            if declaration.initial is not None or declaration.arguments or placed.type.is_view:
                signature.starts.append((declaration, placed))

    def _parameter(self, signature: Signature, block: VarBlock, declaration: Declaration) -> None:
        names = self._names
        for variable, at in names.records.declared(block, declaration, signature.scope):
            if signature.frame.find(variable.name.lower()) is not None:
                raise Unexpected(
                    at,
                    f"{signature.name} has two variables named {variable.name}",
                    Code.DUPLICATE_NAME,
                )
            placed = signature.frame.add(variable)
            bounds = [signature.frame.hidden(name, DINT) for name in _bounds(declaration, placed)]
            signature.parameters.append(
                DeclaredParameter(
                    placed,
                    block.section,
                    _declared_type(placed, block.section),
                    "CONSTANT" in block.qualifiers,
                    tuple(bounds),
                    declaration.initial is not None,
                )
            )
            if declaration.initial is not None and variable.start_values:
                signature.starts.append((declaration, placed))

    def _parameters_of_record(self, signature: Signature) -> None:
        """Add the parameters of a block (with its bases) or a program: members of its record."""
        record = signature.this
        if record is None:
            record = self._names.unit(signature.entry).__iec__
        scopes = list(with_bases(signature.scope))
        for member in record.members:
            for scope in scopes:
                declared = scope.variables.get(member.name.lower())
                if declared is None or declared[0].section not in _PARAMETERS:
                    continue
                block, declaration = declared
                bounds = tuple(record.member(name) for name in _bounds(declaration, member))
                signature.parameters.append(
                    DeclaredParameter(
                        member,
                        block.section,
                        _declared_type(member, block.section),
                        "CONSTANT" in block.qualifiers,
                        bounds,
                        True,
                    )
                )
                break


def _declared_type(variable: Variable[Any, Any], section: str) -> IecType[Any]:
    if section == "VAR_IN_OUT":
        assert isinstance(variable.type, ReferenceType)
        return variable.type.target
    return variable.type


def _bounds(declaration: Declaration, variable: Variable[Any, Any]) -> list[str]:
    """Return the hidden variables with the bounds of an ARRAY [*], lower and upper by dimension."""
    one = f"__{variable.name}_".lower()
    return [name for name in bound_names(declaration) if name.lower().startswith(one)]


def attributes_in(tree: SignatureTree | Unit) -> dict[str, str]:
    """Return the attributes of a unit or part, by name in lower case."""
    note = getattr(tree, "note", NO_NOTE)
    return {name.lower(): value for name, value in attributes_of(note).items()}


def by_position(
    signature: Signature | None, parameters: Sequence[DeclaredParameter]
) -> Sequence[DeclaredParameter]:
    """The parameters in the order of arguments without names: of blocks the outputs are last."""
    if signature is not None and signature.kind in (RoutineKind.FUNCTION, RoutineKind.METHOD):
        return parameters
    inputs = [item for item in parameters if item.section != "VAR_OUTPUT"]
    return inputs + [item for item in parameters if item.section == "VAR_OUTPUT"]
