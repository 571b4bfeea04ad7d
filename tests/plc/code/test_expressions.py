"""Emitted expressions compute what the typed form says, for random trees and values."""

from collections.abc import Callable
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec.elementary import (
    BYTE,
    DINT,
    DWORD,
    INT,
    LINT,
    LREAL,
    LWORD,
    REAL,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    WORD,
    IntegerType,
)  # fmt: skip
from achse.st.check import folding
from achse.st.check.folding import folded
from achse.st.typed.expressions import (
    Computed,
    Conversion,
    Converted,
    Known,
    Operator,
    Read,
    Stored,
    TypedValue,
)  # fmt: skip
from achse.st.typed.statements import Do

INTEGERS = [SINT, USINT, BYTE, INT, UINT, WORD, DINT, UDINT, DWORD, LINT, ULINT, LWORD]
WIDE = [DINT, UDINT, DWORD, LINT, ULINT, LWORD]
TWO = [
    Operator.ADD,
    Operator.SUB,
    Operator.MUL,
    Operator.AND,
    Operator.OR,
    Operator.XOR,
    Operator.DIV,
    Operator.MOD,
    Operator.MIN,
    Operator.MAX,
]
ONE = [Operator.NEG, Operator.NOT, Operator.ABS]
SHIFTS = [Operator.SHL, Operator.SHR, Operator.ROL, Operator.ROR]
TYPES: dict[str, Any] = {f"v{type.name}": type for type in INTEGERS}
_bench: Any = None


def numbers(type: IntegerType) -> st.SearchStrategy[int]:
    edges = [type.low, type.high, 0, 1, type.high // 2, type.low + 1]
    return st.one_of(st.sampled_from(edges), st.integers(type.low, type.high))


def trees(type: IntegerType, depth: int) -> st.SearchStrategy[Any]:
    """Trees of computations: ('var' | 'known' | operator …)."""
    leaf = st.one_of(
        st.just(("var", type)), numbers(type).map(lambda value: ("known", value, type))
    )
    if not depth:
        return leaf
    inner = trees(type, depth - 1)
    converted = st.sampled_from(INTEGERS).flatmap(
        lambda source: trees(source, depth - 1).map(lambda tree: ("to", tree, source, type))
    )
    two = st.tuples(st.sampled_from(TWO), inner, inner).map(lambda t: (*t, type))
    one = st.tuples(st.sampled_from(ONE), inner).map(lambda t: (*t, type))
    shift = st.tuples(st.sampled_from(SHIFTS), inner, trees(DINT, depth - 1)).map(
        lambda t: (*t, type)
    )
    return st.one_of(leaf, converted, two, one, shift)


def built(tree: Any, read: Callable[[str, Any], TypedValue]) -> TypedValue:
    """The tree as a typed value; variables as `read` gives them."""
    head = tree[0]
    if head == "var":
        return read(f"v{tree[1].name}", tree[1])
    if head == "known":
        return Known(tree[1], tree[2])
    if head == "to":
        _, inner, source, target = tree
        inner = built(inner, read)
        if source is target or source.code == target.code:
            return inner
        fits = target.low <= source.low and source.high <= target.high
        return Converted(inner, target, Conversion.EXTEND if fits else Conversion.CUT)
    operands = tuple(built(one, read) for one in tree[1:-1])
    return Computed(head, operands, tree[-1])


def folded_tree(value: TypedValue) -> Any:
    """The oracle: every node folded by the checker's constants."""
    if isinstance(value, Converted):
        return folded(Converted(folded_tree(value.operand), value.type, value.rule))
    if isinstance(value, Computed):
        operands = tuple(folded_tree(one) for one in value.operands)
        if any(not isinstance(one, Known) for one in operands):
            return None
        return folded(Computed(value.operator, operands, value.type))
    return value


@settings(max_examples=75)
@given(data=st.data())
def test_random_whole_numbers(bench: Callable[..., Any], data: st.DataObject) -> None:
    """Random trees of all operators, widths and signs store the bytes that the oracle says."""
    type = data.draw(st.sampled_from(WIDE))
    tree = data.draw(trees(type, 3))
    target = data.draw(st.sampled_from(INTEGERS))
    values = {f"v{each.name}": data.draw(numbers(each)) for each in INTEGERS}
    known = built(tree, lambda name, kind: Known(values[name], kind))
    expected = folded_tree(known)
    if not isinstance(expected, Known):
        return  # A division by 0 in it.
    if target.code != type.code:
        fits = target.low <= type.low and type.high <= target.high
        rule = Conversion.EXTEND if fits else Conversion.CUT
        expected = folded(Converted(expected, target, rule))
    place = bench({**TYPES, "result": target})
    value = built(tree, lambda name, kind: Read(place.storage(name), kind))
    if target.code != type.code:
        value = Converted(value, target, rule)
    data_in = {
        name: number.to_bytes(TYPES[name].size, "little", signed=TYPES[name].low < 0)
        for name, number in values.items()
    }
    place.run(Do(Stored(place.storage("result"), value, target)), **data_in)
    got = int.from_bytes(place.read("result"), "little", signed=target.low < 0)
    assert got == expected.value


def test_a_number_shifted_by_a_variable_is_no_constant(run: Callable[..., Any]) -> None:
    """As a count of another shift it was taken for 31: for what SHR gives at a count of 0."""
    ran = run(
        "PROGRAM MAIN VAR n : DINT := -1; a, b : DINT; END_VAR"
        " a := SHL(n, SHR(DINT#2147483647, n)); b := MAX(SHR(DINT#7, n), 3); END_PROGRAM"
    )
    assert (ran["a"], ran["b"]) == (-1, 3)


REALS = [Operator.ADD, Operator.SUB, Operator.MUL, Operator.MIN, Operator.MAX]


def real_trees(depth: int) -> st.SearchStrategy[Any]:
    """Trees of real computations of either width, with conversions between them."""
    floats = st.floats(-1e6, 1e6, width=32)
    leaf = st.one_of(
        st.just(("var", "r")), st.just(("var", "d")), floats.map(lambda value: ("known", value))
    )
    if not depth:
        return leaf
    inner = real_trees(depth - 1)
    two = st.tuples(st.sampled_from(REALS), inner, inner, st.sampled_from([REAL, LREAL]))
    return st.one_of(leaf, two)


def real_built(tree: Any, type: Any, read: Callable[[str], TypedValue]) -> TypedValue:
    if tree[0] == "known":
        return Known(folding.real(tree[1], type), type)
    if tree[0] == "var":
        value = read(tree[1])
    else:
        operands = tuple(real_built(one, tree[3], read) for one in tree[1:3])
        value = Computed(tree[0], operands, tree[3])
    return value if value.type is type else folded(Converted(value, type, Conversion.RESIZE_REAL))


@settings(max_examples=38)
@given(
    tree=real_trees(4),
    r=st.floats(-1e6, 1e6, width=32),
    d=st.floats(-1e6, 1e6),
    target=st.sampled_from([REAL, LREAL]),
)
def test_random_reals(
    bench: Callable[..., Any], tree: Any, r: float, d: float, target: Any
) -> None:
    """REAL is rounded once per operation, LREAL never: the same bits as the oracle."""
    values = {"r": (r, REAL), "d": (d, LREAL)}
    expected = folded_tree(real_built(tree, target, lambda name: Known(*values[name])))
    assert isinstance(expected, Known)
    place = bench({"r": REAL, "d": LREAL, "result": target})
    value = real_built(tree, target, lambda name: Read(place.storage(name), values[name][1]))
    data = {name: type.codec.pack(number) for name, (number, type) in values.items()}
    place.run(Do(Stored(place.storage("result"), value, target)), **data)
    assert place.read("result") == target.codec.pack(expected.value)
