"""Initial values as code: what a declaration says of a variable that no image of bytes can."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import ReferenceType, resolved
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.st.check.kinds import known_from
from achse.st.check.meanings import PropertyUse
from achse.st.check.names import replaced
from achse.st.check.operands import TypedOperand, read
from achse.st.declared.scopes import Failed
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    ArrayInitial,
    Call,
    Declaration,
    Expression,
    Initial,
    Repetition,
    StructInitial,
)
from achse.st.typed.expressions import Known, Stored
from achse.st.typed.places import Storage, flat
from achse.st.typed.statements import Do, TypedStatement

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_MOST_PARTS = 1000


class Initials:
    """Makes the statements that give variables their first value, in one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def statements(
        self,
        storage: Storage,
        type: IecType[Any],
        declaration: Declaration,
        *,
        all_of_it: bool = False,
    ) -> list[TypedStatement]:
        """Return the assignments of a declaration; without `all_of_it` those that are not
        constant."""
        initial = declaration.initial
        if initial is None:
            return []
        body = self._body
        try:
            if declaration.is_reference or isinstance(resolved(type), ReferenceType):
                if not isinstance(initial, Expression):
                    raise Unexpected(
                        initial.at, "a REFERENCE is bound to a variable", Code.REFERENCE_INITIAL
                    )
                real = resolved(type)
                target = real.target if isinstance(real, ReferenceType) else type
                address = body.assignments.bound_address(storage.type, target, initial)
                return [Do(Stored(storage, address, storage.type, initial.at), initial.at)]
            return list(self._values(storage, type, initial, all_of_it))
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
        except Failed:
            body.failed = True
        return []

    def defaults(
        self, storage: Storage, type: IecType[Any], declaration: Declaration
    ) -> list[TypedStatement]:
        """Return statements that set the defaults of a record's type for the members that a
        declaration initializes.

        Members have these values before the declaration counts: while siblings start, and in
        FB_init.
        """
        if declaration.initial is None or declaration.is_reference:
            return []
        try:
            return list(self._defaults(storage, type, declaration.initial, type.default))
        except (Unexpected, Failed):
            return []  # `statements` reports it

    def reset(self, storage: Storage, type: StructType[Any], at: int) -> list[TypedStatement]:
        """Return statements that set all members of a record to the defaults of its type.

        Raises `Unexpected` if it has more parts than a program can say one by one.
        """
        statements: list[TypedStatement] = []
        for statement in self._resets(storage, type, type.default, at):
            statements.append(statement)
            if len(statements) > _MOST_PARTS:
                raise Unexpected(
                    at,
                    f"an FB_init that {type.name} does not declare sets at most {_MOST_PARTS}"
                    " values",
                    Code.UNKNOWN_MEMBER,
                )
        return statements

    def _resets(
        self, storage: Storage, type: IecType[Any], image: bytes, at: int
    ) -> Iterator[TypedStatement]:
        real = resolved(type)
        if isinstance(real, StructType):
            members = real.fields if real.kind is not RecordKind.UNION else real.fields[:1]
            for member in members:
                part = image[member.offset : member.offset + member.type.size]
                if member.bit is not None:
                    part = bytes([part[0] >> member.bit & 1])
                yield from self._resets(_member(storage, member, at), member.type, part, at)
        elif isinstance(real, ArrayType):
            size = real.element.size
            for number in range(real.count):
                offset = storage.offset + number * size
                name = f"{storage.name}[{number}]"
                place = replaced(
                    storage, offset=offset, type=flat(real.element), bit=None, name=name, at=at
                )
                part = image[number * size : (number + 1) * size]
                yield from self._resets(place, real.element, part, at)
        else:
            kind = flat(type)
            yield Do(Stored(storage, known_from(image, kind), kind, at), at)

    def _defaults(
        self, storage: Storage, type: IecType[Any], initial: Initial, image: bytes
    ) -> Iterator[TypedStatement]:
        """`image` is what the type around says the bytes of `storage` start with."""
        real = resolved(type)
        if isinstance(initial, StructInitial) and isinstance(real, StructType):
            for item in initial.members:
                if real.has_member(item.name):
                    member = real.member(item.name)
                    part = image[member.offset : member.offset + member.type.size]
                    if member.bit is not None:
                        part = bytes([part[0] >> member.bit & 1])
                    place = _member(storage, member, item.at)
                    yield from self._defaults(place, member.type, item.value, part)
        elif isinstance(initial, ArrayInitial) and isinstance(real, ArrayType):
            size = real.element.size
            for position, (place, value) in enumerate(self._placed(storage, real, initial)):
                part = image[position * size : (position + 1) * size]
                yield from self._defaults(place, real.element, value, part)
        elif not isinstance(real, StructType | ArrayType):
            kind = flat(type)
            yield Do(Stored(storage, known_from(image, kind), kind, initial.at), initial.at)

    def _values(
        self, storage: Storage, type: IecType[Any], initial: Initial, all_of_it: bool
    ) -> Iterator[TypedStatement]:
        real = resolved(type)
        if isinstance(initial, StructInitial):
            yield from self._members(storage, real, initial, all_of_it)
        elif isinstance(initial, ArrayInitial):
            if isinstance(real, ArrayType):
                yield from self._elements(storage, real, initial, all_of_it)
        else:
            value = self._body.expressions.operand(initial)
            stored = self._body.assignments.store(storage, type, value, initial.at, initial.at)
            node = stored.value
            assert isinstance(node, Stored)
            if all_of_it or not isinstance(node.value, Known):
                yield Do(node, initial.at)

    def _members(
        self, storage: Storage, type: IecType[Any], initial: StructInitial, all_of_it: bool
    ) -> Iterator[TypedStatement]:
        if not isinstance(type, StructType):
            return
        body = self._body
        for item in initial.members:
            if type.has_member(item.name):
                member = type.member(item.name)
                place = _member(storage, member, item.at)
                if isinstance(resolved(member.type), ReferenceType):
                    real = resolved(member.type)
                    assert isinstance(real, ReferenceType)
                    if isinstance(item.value, Expression):
                        address = body.assignments.bound_address(real, real.target, item.value)
                        yield Do(Stored(place, address, real, item.at), item.at)
                    continue
                if item.is_reference:
                    raise Unexpected(
                        item.at,
                        f"REF= binds a reference, not a {member.type.name}",
                        Code.REFERENCE_INITIAL,
                    )
                yield from self._values(place, member.type, item.value, all_of_it)
                continue
            if body.checking.names.predefined.has_property(type.name, item.name):
                continue  # of a library whose code is not here: there is no SET to call
            whole = read(storage, type, item.at)
            property_use = body.paths.member_of(whole, item.name, item.at)
            if not isinstance(property_use, PropertyUse) or not isinstance(item.value, Expression):
                raise Unexpected(
                    item.at, f"{type.name} has no member '{item.name[:80]}'", Code.UNKNOWN_MEMBER
                )
            value = body.expressions.operand(item.value)
            yield Do(body.calls.write_property(property_use, value, item.at), item.at)

    def _elements(
        self, storage: Storage, type: ArrayType[Any], initial: ArrayInitial, all_of_it: bool
    ) -> Iterator[TypedStatement]:
        for place, value in self._placed(storage, type, initial):
            yield from self._values(place, type.element, value, all_of_it)

    def _placed(
        self, storage: Storage, type: ArrayType[Any], initial: ArrayInitial
    ) -> Iterator[tuple[Storage, Initial]]:
        """Return the elements with a value, and the values."""
        element = type.element
        for position, value in enumerate(self._flattened(type, initial.values)):
            if position >= type.count:
                return
            offset = storage.offset + position * element.size
            name = f"{storage.name}[{position}]"
            yield replaced(storage, offset=offset, type=flat(element), name=name), value

    def _flattened(
        self, type: ArrayType[Any], values: Sequence[Initial | Repetition]
    ) -> Iterator[Initial]:
        """Return the values in order, repeated ones as often as they count."""
        nested = isinstance(resolved(type.element), ArrayType)
        for item in values:
            if isinstance(item, ArrayInitial) and not nested:
                yield from self._flattened(type, item.values)
            elif isinstance(item, Repetition):
                count = self._count(item.count)
                for _ in range(count):
                    yield from item.values
            elif isinstance(item, Call) and self._counts(item):
                for _ in range(self._count(item.of)):
                    for argument in item.arguments:
                        if argument.value is not None:
                            yield argument.value
            else:
                yield item

    def _counts(self, item: Call) -> bool:
        """Return True if `cCount(0)` is a repetition and not a call."""
        if any(argument.name for argument in item.arguments):
            return False
        meaning = self._body.expressions.meaning(item.of)
        return isinstance(meaning, TypedOperand) and isinstance(meaning.constant, int)

    def _count(self, tree: Expression) -> int:
        value = self._body.expressions.operand(tree).constant
        if not isinstance(value, int):
            raise Unexpected(
                tree.at, "how often a value repeats is a constant", Code.CONSTANT_EXPECTED
            )
        return value


def _member(storage: Storage, member: Variable[Any, Any], at: int) -> Storage:
    """Return the storage of a member of a record."""
    return replaced(
        storage,
        offset=storage.offset + member.offset,
        type=flat(member.type),
        bit=member.bit,
        name=f"{storage.name}.{member.name}",
        at=at,
    )
