"""Elements at an index, of arrays, pointers and texts."""

from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType
from achse.iec.elementary import BYTE, DINT, LINT, WORD, IntegerType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.folding import folded
from achse.st.check.kinds import counted
from achse.st.check.names import replaced
from achse.st.check.operands import TypedOperand, read
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Index
from achse.st.typed.expressions import (
    Computed,
    Known,
    Operator,
    Read,
    TypedValue,
)
from achse.st.typed.places import (
    IndexStep,
    PointerBase,
    Storage,
    flat,
)

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody


class Elements:
    """Follows the indices of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def index(self, tree: Index) -> TypedOperand:
        """`of[i, j]`."""
        whole = self._body.expressions.operand(tree.of)
        indices = [(self._index_value(item), item.at) for item in tree.indices]
        at = tree.at
        if whole.bounds:
            return self._open_element(whole, indices, at)
        while indices:
            type = whole.flat
            if isinstance(type, ArrayType):
                count = len(type.dimensions)
                if len(indices) < count:
                    raise Unexpected(
                        at, f"{type.name} takes {count} indices, got {len(indices)}", Code.BAD_INDEX
                    )
                whole = self._element(whole, type, indices[:count], at)
                indices = indices[count:]
            elif isinstance(type, PointerType) and not isinstance(type, InterfaceType):
                whole = self._pointed_element(whole, type, indices[0], at)
                indices = indices[1:]
            elif isinstance(type, StringType):
                whole = self._character(whole, type, indices[0], at)
                indices = indices[1:]
            else:
                raise Unexpected(at, f"a {whole.type.name} has no elements", Code.BAD_INDEX)
        return whole

    def _index_value(self, tree: Any) -> TypedValue:
        operand = self._body.expressions.operand(tree)
        if not isinstance(operand.flat, IntegerType):
            raise Unexpected(
                tree.at, f"an index is a whole number, got a {operand.type.name}", Code.BAD_INDEX
            )
        wide = LINT if counted(operand.flat).high > DINT.high else DINT
        if operand.is_constant:
            wide = DINT
        return converted(operand.value, wide, tree.at)

    def _element(
        self,
        whole: TypedOperand,
        type: ArrayType[Any],
        indices: list[tuple[TypedValue, int]],
        at: int,
    ) -> TypedOperand:
        outer = self._body.paths.storage(whole, at)
        offset = outer.offset
        steps = list(outer.steps)
        name = outer.name
        written = []
        for (index, place), bounds, stride in zip(
            indices, type.dimensions, type.strides, strict=True
        ):
            if isinstance(index, Known):
                number = index.value
                assert isinstance(number, int)
                if not bounds.first <= number <= bounds.last:
                    raise Unexpected(
                        place,
                        f"index {number} is outside {bounds} of {type.name}",
                        Code.INDEX_OUT_OF_BOUNDS,
                    )
                offset += (number - bounds.first) * stride
                written.append(str(number))
                continue
            first, last = Known(bounds.first, DINT, place), Known(bounds.last, DINT, place)
            checked = self._body.checks.bounds(index, first, last, place)
            steps.append(self._step(checked, first, last, stride, place))
        if written and len(written) == len(indices):
            name = f"{name}[{','.join(written)}]"
        storage = replaced(
            outer,
            offset=offset,
            steps=tuple(steps),
            type=flat(type.element),
            name=name,
            at=at,
        )
        self._body.mark_addressed(storage)
        return read(storage, type.element, at)

    def _step(
        self, index: TypedValue, first: TypedValue, last: TypedValue, stride: int, at: int
    ) -> IndexStep:
        """Return the step of an index between bounds, which count if the project checks them."""
        return IndexStep(
            index, first, last if self._body.checking.check_bounds else None, stride, at
        )

    def _open_element(
        self, whole: TypedOperand, indices: list[tuple[TypedValue, int]], at: int
    ) -> TypedOperand:
        """Return an element of an ARRAY [*]: its bounds are in hidden variables."""
        count = len(whole.bounds) // 2
        if len(indices) != count:
            raise Unexpected(
                at, f"this ARRAY [*] takes {count} indices, got {len(indices)}", Code.BAD_INDEX
            )
        outer = self._body.paths.storage(whole, at)
        size = whole.flat.size
        # The stride of all dimensions but the last shows at run time only: one step for all.
        position: TypedValue | None = None
        for number, (index, place) in enumerate(indices):
            lower, upper = whole.bounds[2 * number : 2 * number + 2]
            checked = self._body.checks.bounds(index, lower, upper, place)
            if count == 1:
                step = self._step(checked, lower, upper, size, place)
                storage = replaced(outer, steps=(*outer.steps, step), at=at)
                return read(storage, whole.type, at)
            inside = _dint(Operator.SUB, checked, lower, place)
            if position is None:
                position = inside
                continue
            one = Known(1, DINT, place)
            span = _dint(Operator.ADD, _dint(Operator.SUB, upper, lower, place), one, place)
            before = _dint(Operator.MUL, position, span, place)
            position = _dint(Operator.ADD, before, inside, place)
        assert position is not None
        first: TypedValue = Known(0, DINT, at)
        last: TypedValue = Known(1, DINT, at)
        for number in range(count):
            lower, upper = whole.bounds[2 * number : 2 * number + 2]
            span = _dint(
                Operator.ADD, _dint(Operator.SUB, upper, lower, at), Known(1, DINT, at), at
            )
            last = _dint(Operator.MUL, last, span, at)
        last = _dint(Operator.SUB, last, Known(1, DINT, at), at)
        step = self._step(position, first, last, size, at)
        return read(replaced(outer, steps=(*outer.steps, step), at=at), whole.type, at)

    def _pointed_element(
        self,
        whole: TypedOperand,
        type: PointerType,
        index: tuple[TypedValue, int],
        at: int,
    ) -> TypedOperand:
        """`p[i]`: the i-th element from where a pointer leads."""
        target = type.target
        base = PointerBase(self._body.checks.pointer(whole.value, type, at))
        name = whole.storage.name if whole.storage is not None else ""
        value, place = index
        if isinstance(value, Known):
            assert isinstance(value.value, int)
            storage = Storage(base, value.value * target.size, flat(target), name=f"{name}^", at=at)
        else:
            step = IndexStep(value, Known(0, DINT, place), None, target.size, place)
            storage = Storage(base, 0, flat(target), steps=(step,), name=f"{name}^", at=at)
        return read(storage, target, at)

    def _character(
        self, whole: TypedOperand, type: StringType, index: tuple[TypedValue, int], at: int
    ) -> TypedOperand:
        """`s[i]`: the i-th byte (of a WSTRING word) of a text, from 0."""
        outer = self._body.paths.storage(whole, at)
        element: IecType[Any] = BYTE if type.unit == 1 else WORD
        value, place = index
        if isinstance(value, Known):
            assert isinstance(value.value, int)
            if not 0 <= value.value <= type.length:
                raise Unexpected(
                    place,
                    f"index {value.value} is outside 0..{type.length}",
                    Code.INDEX_OUT_OF_BOUNDS,
                )
            offset = outer.offset + value.value * type.unit
            storage = replaced(outer, offset=offset, type=element, at=at)
        else:
            first, last = Known(0, DINT, place), Known(type.length, DINT, place)
            step = self._step(value, first, last, type.unit, place)
            storage = replaced(outer, steps=(*outer.steps, step), type=element, at=at)
        self._body.mark_addressed(storage)
        return TypedOperand(Read(storage, element, at), element, storage)


def _dint(operator: Operator, left: TypedValue, right: TypedValue, at: int) -> TypedValue:
    return folded(Computed(operator, (left, right), DINT, at))
