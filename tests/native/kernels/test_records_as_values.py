"""Records as values in kernels: copied, reset, made, passed and returned, in both forms."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.native.compiled import Kernel, checked_builds
from achse.native.declare import Slot, assign, lay_out, pack, reference, reset, within
from achse.native.kernels.arithmetic import TranslationError
from achse.native.kernels.translate import translate
from achse.native.memory import Rows, RowView, structure_of


class Wheel:
    angle: float = 0.5
    turns: int = 3
    marks: list[float] = [0.25] * 3


WHEEL = lay_out("wheel", [Wheel], Slot)


class Axle:
    left: Any = within(WHEEL)
    load: float = 2.0
    spare: Any = within(WHEEL, length=2)


AXLE = lay_out("axle", [Axle], Slot)


class Cart:
    now: Any = within(AXLE)
    number: int = 7
    following: Any = within(AXLE)


CART = lay_out("cart", [Cart], Slot, whole_lines=True)

SOURCE = """
from collections.abc import Sequence

def spare(axle: Axle, n: int) -> Wheel:
    return axle.spare[n]

def chosen(cart: Cart, first: int) -> Axle:
    return cart.now if first else cart.following

def swap(cart: Cart) -> None:
    between = AXLE.plain()
    assign(between, cart.now)
    assign(cart.now, cart.following)
    assign(cart.following, between)

def doubled(wheel: Wheel, source: Wheel) -> float:
    assign(wheel, source)
    wheel.angle *= 2.0
    return wheel.angle

def run(carts: Sequence[Cart], operation: int, n: int, m: int, value: float) -> float:
    cart = carts[n]
    if operation == 0:
        swap(cart)
    elif operation == 1:
        assign(cart.now, carts[m].following)
    elif operation == 2:
        reset(cart.now)
    elif operation == 3:
        reset(chosen(cart, m).spare[1])
    elif operation == 4:
        wheel = spare(chosen(cart, m), m)
        wheel.angle = value
        wheel.turns += 1
        wheel.marks[2] -= value
    elif operation == 5:
        wheel = WHEEL.plain()
        total = doubled(wheel, cart.now.left) + wheel.turns
        for _ in range(m + 1):
            wheel = WHEEL.plain()
            total += doubled(wheel, wheel)
        return total
    else:
        assign(chosen(cart, m).left, spare(cart.now, m))
    return cart.now.load + cart.now.left.angle
"""

NAMES = {"Wheel": Wheel, "Axle": Axle, "Cart": Cart, "AXLE": AXLE, "WHEEL": WHEEL}
LAYOUTS: dict[type, Any] = {Wheel: WHEEL, Axle: AXLE, Cart: CART}


@pytest.fixture(scope="module")
def kernel(written: Callable[..., ModuleType]) -> Kernel:
    module = written(SOURCE, **NAMES, assign=assign, reset=reset)
    return Kernel("carts", module.run, LAYOUTS)


STEPS = st.lists(
    st.tuples(st.integers(0, 6), st.integers(0, 1), st.integers(0, 1), st.floats(-9.0, 9.0)),
    min_size=1,
    max_size=12,
)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(STEPS)
@pytest.mark.parametrize("checked", [False, True])
def test_records_as_values_are_the_same_in_both_forms(
    kernel: Kernel, checked: bool, steps: list[tuple[int, int, int, float]]
) -> None:
    plain: list[Any] = [CART.plain(), CART.plain()]
    rows = Rows(CART, 2)
    for n, cart in enumerate(plain):
        rows.row(n)[: CART.form.size] = pack(CART, cart)
    run = kernel.plain
    if checked:
        with checked_builds():
            code = kernel.bind(rows.address, 2)
    else:
        code = kernel.bind(rows.address, 2)
    for step in steps:
        assert code(*step) == run(plain, *step)
        for n, cart in enumerate(plain):
            assert RowView(rows, n).content(CART) == pack(CART, cart)


@given(st.floats(-9.0, 9.0), st.integers(-9, 9))
def test_values_go_from_any_form_to_any_other(angle: float, turns: int) -> None:
    rows = Rows(CART, 2)
    memory: Any = structure_of(CART).from_buffer(rows.row(1))
    plain: Any = CART.plain()
    plain.now.spare[1].angle, plain.following.left.turns = angle, turns
    plain.now.left.marks[1] = angle
    assign(memory, plain)
    assert RowView(rows, 1).content(CART) == pack(CART, plain)
    other: Any = CART.plain()
    assign(other, memory)
    assert pack(CART, other) == pack(CART, plain)
    assign(plain.now.left, other.now.spare[1])
    other.now.spare[1].angle += 1.0
    assert (plain.now.left.angle, plain.now.left.marks[1]) == (angle, 0.25)
    reset(memory)
    assert RowView(rows, 1).content(CART) == pack(CART, CART.plain())
    assert bytes(rows.row(0)) == bytes(rows.size)


def test_record_of_another_layout_cannot_be_assigned() -> None:
    with pytest.raises(TypeError, match="cannot assign a wheel: expected a axle"):
        assign(AXLE.plain(), WHEEL.plain())


class Near:
    wheel: Any = reference(WHEEL)


NEAR = lay_out("near", [Near], Slot)


@pytest.mark.parametrize(
    ("line", "refusal"),
    [
        ("assign(cart.now, cart.now.left)", "not of records of one layout"),
        ("assign(cart.now, cart.number)", "not of records of one layout"),
        ("reset(cart.number)", "not of records of one layout"),
        ("assign(cart.now)", "arguments of"),
        ("reset(cart.now, cart.now)", "arguments of"),
        ("reset(record=cart.now)", "arguments of"),
        ("reset(near)", "a near refers to other records"),
        ("near = NEAR.plain()", "references of"),
        ("near = WHEEL.plain(3)", "arguments or"),
        ("cart.now = cart.following", "only numbers can be stored"),
        ("return WHEEL.plain()", "a record of its own cannot be returned"),
    ],
)
def test_kernel_refuses_what_is_no_value(
    written: Callable[..., ModuleType], line: str, refusal: str
) -> None:
    result = "Wheel" if line.startswith("return") else "None"
    text = f"def run(cart: Cart, near: Near) -> {result}:\n    {line}\n"
    names = NAMES | {"Near": Near, "NEAR": NEAR, "assign": assign, "reset": reset}
    module = written(text, **names)
    with pytest.raises(TranslationError, match=refusal):
        translate(module.run, LAYOUTS | {Near: NEAR})
