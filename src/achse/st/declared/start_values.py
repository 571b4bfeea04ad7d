"""Start values: what an initial value that is not a constant comes to once memory is laid out.

That is the address of a variable (`ADR(x)`, `REF= x`, THIS, a function block for a variable of
its interface), the value of a variable, and what expressions make of these. Calls of functions
and methods take a running program.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType, ReferenceType, resolved
from achse.iec.elementary import BOOL, BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.paths import PathIndex, follow
from achse.iec.paths import PathMember as MemberStep
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.iec.variables import PointedValue, StartContext, StartValue
from achse.st.declared.scopes import Scope
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Call, Dereference, Expression, Member, This
from achse.st.syntax.tree import Index as IndexTree
from achse.st.values.constants import path_of
from achse.st.values.initials import NonConstantPart
from achse.st.values.values import Constant, NotConstant, fitted

if TYPE_CHECKING:
    from achse.st.declared.resolve import Resolver

_LEFT = "starts as its type says"


class StartValues:
    """Works out start values as the inside of `scope` sees them.

    `own` is the record whose variable starts: a function block, a structure, a program. All
    methods raise `NotConstant` for what takes a running program, and `Unexpected`.
    """

    def __init__(
        self, names: "Resolver", scope: Scope, surroundings: StartContext, own: PointedValue
    ) -> None:
        self._names = names
        self._scope = scope
        self._surroundings = surroundings
        self._own = own
        self._evaluator = names.constants.evaluator(scope, self._constant)

    def encoded(self, type: IecType[Any], tree: Expression) -> bytes:
        """Return the value of an expression, as a variable of `type` holds it."""
        real = resolved(type)
        if isinstance(real, StructType | ArrayType | InterfaceType):
            spot = self._value(tree)
            is_block = isinstance(resolved(spot.type), StructType)
            if isinstance(real, InterfaceType) and is_block:
                return type.encode(spot.address)
            if spot.type.guid != type.guid:
                raise Unexpected(
                    tree.at, f"{type.name} takes no {spot.type.name}", Code.BAD_START_VALUE
                )
            return self._surroundings.read(spot.address, type.size)
        return type.encode(fitted(self._evaluator.value(tree), type, tree.at))

    def address(self, type: IecType[Any], tree: Expression) -> bytes:
        """Return the address of a variable, as a reference of `type` holds it."""
        return type.encode(self._value(tree).address)

    def arguments(self, type: IecType[Any], tree: Expression) -> bytes:
        """Raise `Unexpected`: FB_init is not called, so its arguments have no effect."""
        raise Unexpected(tree.at, f"FB_init of {type.name} is not called", Code.INIT_ARGUMENTS)

    # values ----------------------------------------------------------------------------------

    def _constant(self, tree: Expression) -> Constant:
        """Return the value of an expression that the evaluator finds not constant."""
        if isinstance(tree, This):
            return Constant(self._own.address)
        if isinstance(tree, Call) and len(tree.arguments) == 1:
            operand = tree.arguments[0].value
            if operand is not None and (path_of(tree.of) or ("",))[-1].upper() == "ADR":
                return Constant(self._value(operand).address)
        spot = self._value(tree)
        real = resolved(spot.type)
        data = self._read(spot.address, real.size, tree.at)
        if spot.bit is not None:
            return Constant(bool(data[0] >> spot.bit & 1), BOOL)
        if isinstance(real, EnumType):
            return Constant(real.base.decode(data), real)
        if isinstance(real, TimeType):
            return Constant(int.from_bytes(data, "little"), real)
        if isinstance(real, BoolType | IntegerType | RealType | StringType):
            return Constant(real.decode(data), real)
        if isinstance(real, PointerType):
            return Constant(real.decode(data))
        raise NotConstant(tree.at)

    # variables -------------------------------------------------------------------------------

    def _value(self, tree: Expression) -> PointedValue:
        """Return the variable that an expression names; for a reference, the variable behind it."""
        spot = self._spot(tree)
        real = resolved(spot.type)
        if isinstance(real, ReferenceType):
            return self._pointee(spot.address, real, tree.at)
        return spot

    def _spot(self, tree: Expression) -> PointedValue:
        if isinstance(tree, Dereference):
            if isinstance(tree.of, This):
                return self._own
            pointer = self._value(tree.of)
            real = resolved(pointer.type)
            if not isinstance(real, PointerType):
                raise Unexpected(
                    tree.at,
                    f"{pointer.type.name} is not a pointer: ^ has no target",
                    Code.NOT_A_POINTER,
                )
            return self._pointee(pointer.address, real, tree.at)
        if isinstance(tree, IndexTree):
            indices = [self._evaluator.integer(item, "an index", tree.at) for item in tree.indices]
            return self._part(self._value(tree.of), PathIndex(tuple(indices)), tree.at)
        path = path_of(tree)
        if path is not None:
            return self._named(path, tree.at)
        if isinstance(tree, Member):
            return self._part(self._value(tree.of), MemberStep(tree.name), tree.at)
        raise NotConstant(tree.of.at if isinstance(tree, Call) else tree.at)

    def _named(self, path: tuple[str, ...], at: int) -> PointedValue:
        """Return the variable `a.b.c`: of the own record, of a list or of a program."""
        match = self._names.scopes.variable(path, self._scope)
        if match is None and not self._names.constants.is_inherited(path[0].lower(), self._scope):
            raise NotConstant(at)
        owner, rest = match or (self._scope, list(path))
        if self._names.scopes.is_placed(owner):
            try:
                spot = self._surroundings.variable(f"{owner.owner}.{rest[0]}")
            except KeyError:
                raise Unexpected(
                    at, f"{owner.owner}.{rest[0]} has no place in memory", Code.BAD_START_VALUE
                ) from None
        else:
            spot = self._part(self._own, MemberStep(rest[0]), at)
        for name in rest[1:]:
            if isinstance(real := resolved(spot.type), ReferenceType):
                spot = self._pointee(spot.address, real, at)
            spot = self._part(spot, MemberStep(name), at)
        return spot

    def _part(self, whole: PointedValue, step: MemberStep | PathIndex, at: int) -> PointedValue:
        try:
            target = follow(whole.type, (step,))
        except IecError as error:
            raise Unexpected(at, str(error), Code.BAD_START_VALUE) from None
        if target.static is not None:
            raise NotConstant(at)
        return PointedValue(target.type, whole.address + target.offset, target.bit)

    def _pointee(self, place: int, pointer: PointerType, at: int) -> PointedValue:
        address = pointer.decode(self._read(place, pointer.size, at))
        if not address:
            raise Unexpected(at, f"this {pointer.name} has no target yet", Code.BAD_START_VALUE)
        return PointedValue(pointer.target, address)

    def _read(self, address: int, size: int, at: int) -> bytes:
        try:
            return self._surroundings.read(address, size)
        except LookupError:
            raise Unexpected(
                at, f"address 0x{address:X} is not in memory", Code.BAD_START_VALUE
            ) from None


def start_value(
    names: "Resolver",
    scope: Scope,
    part: NonConstantPart,
    work_out: Callable[[StartValues, IecType[Any], Expression], bytes] = StartValues.encoded,
) -> StartValue:
    """Return a part of an initial value that is not a constant, to be worked out when there is
    memory."""
    type, offset, bit, tree = part

    def value(surroundings: StartContext, own: PointedValue) -> bytes:
        try:
            return work_out(StartValues(names, scope, surroundings, own), type, tree)
        except NotConstant as left:
            fault = scope.source.fault(
                left.at, f"shows only when the program runs: {_LEFT}", Code.BAD_START_VALUE
            )
        except Unexpected as left:
            fault = scope.source.fault(left.at, f"{left.message}: {_LEFT}", Code.BAD_START_VALUE)
        raise SourceError([fault])

    return StartValue(type, offset, bit, value)
