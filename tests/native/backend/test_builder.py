"""Functions: memory at any byte, ways, calls in both directions, faults and budgets."""

import random
import struct
from typing import Any

import pytest

from achse.native.backend import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    Effort,
    FunctionBuilder,
    InstructionError,
    MachineCode,
    MachineFault,
    MachineType,
    ModuleBuilder,
    Operand,
    OwnFault,
    Relation,
    address_of,
    builder,
    compile_module,
)

B = FunctionBuilder
TYPES = (BOOL, I8, I16, I32, I64, U8, U16, U32, U64, F32, F64)
FORMS = dict(zip(TYPES, "?bhiqBHIQfd", strict=True))


@pytest.mark.parametrize("type", FORMS, ids=repr)
def test_memory_at_any_byte(type: MachineType, several: Any, drawn: Any) -> None:
    """What is stored at a computed offset is what is loaded, and no other byte changes."""

    def put(body: B, base: Operand, at: Operand, value: Operand) -> None:
        body.store(value, base, at)

    run = several(
        {
            "put": ([ADDRESS, U16, type], None, put),
            "get": ([ADDRESS, I32], type, lambda body, base, at: body.load(type, base, at)),
            "third": ([ADDRESS], type, lambda body, base: body.load(type, base, 3)),
        }
    )
    dice = random.Random(type.name)
    form = struct.Struct("<" + FORMS[type])
    for _ in range(20):
        at, value = dice.randrange(9), drawn(type, dice)
        memory = bytearray(range(32))
        expected = bytearray(memory)
        form.pack_into(expected, at, value)
        run["put"](address_of(memory), at, value)
        assert memory == expected
        assert run["get"](address_of(memory), at) == value
        assert run["get"](address_of(memory, 8), at - 8) == value
        assert run["third"](address_of(memory)) == form.unpack_from(memory, 3)[0]


def test_moving_bytes(several: Any) -> None:
    def clear(body: B, base: Operand, size: Operand) -> None:
        body.fill(base, body.constant(U8, 0xAB), size)

    def shift(body: B, base: Operand, by: Operand) -> None:
        body.copy(body.address(base, by), base, 6)

    def of_element(body: B, base: Operand, index: Operand) -> Operand:
        return body.load(U8, body.address(base, index, 6, within=2))

    def through_buffer(body: B, a: Operand) -> Operand:
        place = body.buffer(3)
        body.store(a, place, 1)
        return body.load(U8, place, 2)

    run = several(
        {
            "fill": ([ADDRESS, U8], None, clear),
            "shift": ([ADDRESS, I16], None, shift),
            "element": ([ADDRESS, I8], U8, of_element),
            "data": ([I64], U8, lambda body, at: body.load(U8, body.module.data(b"abc"), at)),
            "buffer": ([U16], U8, through_buffer),
        }
    )
    memory = bytearray(range(40))
    run["shift"](address_of(memory), 2)
    assert memory[:10] == bytes((0, 1, 0, 1, 2, 3, 4, 5, 8, 9))
    run["fill"](address_of(memory), 3)
    assert memory[:5] == b"\xab\xab\xab\x01\x02"
    assert run["element"](address_of(memory, 6), 4) == 6 + 4 * 6 + 2
    assert run["element"](address_of(memory, 8), -1) == memory[8 - 6 + 2]
    assert run["data"](2) == ord("c")
    assert run["buffer"](0x1234) == 0x12


def test_control(several: Any) -> None:
    def chosen(body: B, number: Operand) -> None:
        labels = {number: body.label() for number in (-1, 7, 100)}
        other = body.label()
        body.switch(number, labels, other)
        for n, label in labels.items():
            body.begin(label)
            body.return_(body.constant(I32, n * 10))
            body.return_(body.constant(I32, 0))  # nothing comes here
        body.begin(other)
        return body.constant(I32, 5)  # type: ignore[return-value]

    def total(body: B, most: Operand) -> Operand:
        """1 + 2 + … + most; a label without a jump is fallen into."""
        i, result = body.variable(I16), body.variable(I16)
        body.set(i, body.constant(I16, 0))
        body.set(result, body.constant(I16, 0))
        again, go_on, end = body.label(), body.label(), body.label()
        body.begin(again)
        body.branch(body.compare(Relation.LESS, body.get(i), most), go_on, end)
        body.begin(go_on)
        body.set(i, body.add(body.get(i), body.constant(I16, 1)))
        body.set(result, body.add(body.get(result), body.get(i)))
        body.jump(again)
        body.begin(end)
        return body.get(result)

    run = several({"chosen": ([I8], I32, chosen), "total": ([I16], I16, total)})
    assert [run["chosen"](n) for n in (-1, 7, 100, 8)] == [-10, 70, 1000, 5]
    assert run["total"](10) == 55
    assert run["total"](300) == 45150 - 65536


def test_functions_of_each_other_and_tables_of_them(load: Any) -> None:
    module = ModuleBuilder()
    both = module.declare("both", [I16, F32], [F32, I16])
    double = module.declare("double", [I16], [I16])
    run = module.function("run", [I16, ADDRESS], [I16], exported=True)
    a, method = run.parameters
    _, back = run.call(both, a, run.constant(F32, 0.5))
    run.return_(*run.call_at(method, double, back))
    body = module.write(both, ["a", "b"])
    body.return_(*reversed(body.parameters))
    where = module.function("where", [], [ADDRESS], exported=True)
    where.return_(where.function_address(double))
    body = module.write(double)
    body.return_(body.add(body.parameters[0], body.parameters[0]))
    code = load(module)
    assert code.function("run")(-700, code.function("where")()) == -1400


def test_faults_reach_python_through_all_callers(load: Any) -> None:
    module = ModuleBuilder()
    inner = module.function("inner", [I16], [I16, I16], faults=True)
    (a,) = inner.parameters
    inner.require(inner.compare(Relation.LESS, a, inner.constant(I16, 10)), 17, a)
    inner.return_(a, a)
    outer = module.function("outer", [I16, ADDRESS], [I16], exported=True, faults=True)
    a, place = outer.parameters
    outer.store(a, place)
    result, _ = outer.call(inner.function, a)
    outer.store(outer.constant(U8, 99), place, 2)
    outer.return_(result)
    run = load(module).function("outer")
    memory = bytearray(3)
    for _ in range(2):
        assert run(-9, address_of(memory)) == -9
        memory[2] = 0
        with pytest.raises(MachineFault) as fault:
            run(12, address_of(memory))
        assert (fault.value.number, fault.value.first, fault.value.second) == (17, 12, 0)
        assert memory == b"\x0c\x00\x00"


def test_a_budget_ends_a_loop(load: Any) -> None:
    module = ModuleBuilder()
    body = module.function("forever", [], exported=True, faults=True)
    again = body.label()
    body.begin(again)
    body.spend(3)
    body.jump(again)
    code = load(module)
    code.budget = 1_000
    with pytest.raises(MachineFault) as fault:
        code.function("forever")()
    assert fault.value.number == OwnFault.BUDGET_SPENT
    assert code.budget == 1_000 - 3 * 334


def test_a_recursion_ends_before_the_stack_does(load: Any) -> None:
    module = ModuleBuilder()
    body = module.function("down", [I32], [I32], exported=True, faults=True)
    body.descend()
    (n,) = body.parameters
    deeper, end = body.label(), body.label()
    body.branch(body.compare(Relation.GREATER, n, body.constant(I32, 0)), deeper, end)
    body.begin(deeper)
    (below,) = body.call(body.function, body.subtract(n, body.constant(I32, 1)))
    body.return_(body.add(below, body.constant(I32, 1)))
    body.begin(end)
    body.return_(n)
    run = load(module).function("down")
    for _ in range(3):
        assert run(900) == 900
        with pytest.raises(MachineFault) as fault:
            run(1_000_000)
        assert fault.value.number == OwnFault.TOO_DEEP


def test_callbacks(load: Any) -> None:
    module = ModuleBuilder()
    ask = module.callback("ask", [I8, U8, BOOL, F32, ADDRESS], [I16])
    assert module.callback("ask", [I8, U8, BOOL, F32, ADDRESS], [I16]) is ask
    report = module.callback("tell", [I16])
    body = module.function("run", [I8, U8, BOOL, F32, ADDRESS], [I16], exported=True, faults=True)
    (answer,) = body.call(ask, *body.parameters)
    body.call(report, answer)
    body.return_(answer)
    seen: list[Any] = []

    def answers(*values: Any) -> int:
        seen.append(values)
        return -int(1 / values[3])

    code = load(module, ask=answers, tell=seen.append)
    run = code.function("run")
    assert run(-5, 250, True, 0.25, 4096) == -4
    assert seen == [(-5, 250, True, 0.25, 4096), -4]
    with pytest.raises(ZeroDivisionError):
        run(-5, 250, True, 0.0, 4096)
    assert len(seen) == 3
    assert run(0, 0, False, 1.0, 1) == -1
    with pytest.raises(TypeError, match="callbacks"):
        load(module, ask=answers)


def test_a_draft_leaves_nothing_behind() -> None:
    body = ModuleBuilder().function("run", [I16], [I16], exported=True)
    (a,) = body.parameters
    with body.draft():
        body.variable(I16)
        type = body.add(a, a).type
        body.return_(a)
    assert type is I16
    assert not body.ended
    body.return_(a)
    assert [line.strip() for line in body.text().splitlines()[1:-1]] == ["begin:", "ret i16 %p0"]


def test_what_does_not_fit_is_refused() -> None:
    module = ModuleBuilder()
    body = module.function("run", [I16, I32], [I16])
    a, b = body.parameters
    for refused, reason in (
        (lambda: body.load(I16, b), "address expected, got i32"),
        (lambda: body.branch(a, "x", "y"), "bool expected, got i16"),
        (lambda: body.return_(), "results"),
        (lambda: body.return_(b), "i16 expected, got i32"),
        (lambda: body.call(body.function, a), "got 1 arguments"),
        (lambda: body.leave(1), "without faults"),
        (lambda: body.call(module.callback("c", [])), "so it faults too"),
    ):
        with pytest.raises(InstructionError, match=reason):
            refused()


def test_an_opening_comes_first_and_knows_what_the_body_needs(load: Any) -> None:
    module = ModuleBuilder()
    body = module.function("run", [I64], [I64], exported=True)
    (values,) = body.parameters
    body.return_(body.add(values, Operand(I64, "%late")))
    with body.opening():
        assert body.named("late", body.constant(I64, 40)).text == "%late"
    assert load(module).function("run")(2) == 42


def test_a_handler_gets_the_fault_and_the_trail_of_places(load: Any) -> None:
    """A fault two calls down: the places it came through, innermost first."""
    module = ModuleBuilder()
    report = module.callback("report", [], [I64])
    inner = module.function("inner", [I64], [I64], faults=True)
    (values,) = inner.parameters
    inner.require(inner.convert(values, BOOL), 7, values)
    inner.return_(*inner.parameters)
    middle = module.function("middle", [I64], [I64], faults=True)
    middle.place = lambda: 11
    middle.return_(*middle.call(inner.function, *middle.parameters))
    for name, safe in (("safe", True), ("bare", False)):
        outer = module.function(name, [I64], [I64], exported=True, faults=True)
        outer.place = lambda: 22
        handler = outer.label()
        with outer.protected(handler if safe else None):
            outer.return_(*outer.call(middle.function, *outer.parameters))
        outer.begin(handler)
        assert outer.handler is None
        outer.return_(*outer.call(report))
    seen: list[Any] = []

    def reported() -> int:
        seen.append(code.caught())
        return -1

    code = load(module, report=reported)
    assert code.function("safe")(5) == 5
    assert code.function("safe")(0) == -1
    ((failure, places),) = seen
    assert failure.number == 7
    assert places == [11, 22]
    with pytest.raises(MachineFault):
        code.function("bare")(0)
    assert next(iter(code.fault_words)) == 0
    assert code.function("safe")(1) == 1


def test_depth_of_calls_is_restored_by_returns_and_faults(effort: Effort) -> None:
    module = ModuleBuilder()
    deep = module.declare("deep", [I64], [I64], exported=True, faults=True)
    body = module.write(deep)
    body.will_descend()
    (n,) = body.parameters
    more, end = body.label(), body.label()
    body.branch(body.convert(n, BOOL), more, end)
    body.begin(more)
    body.return_(*body.call(deep, body.subtract(n, body.constant(I64, 1))))
    body.begin(end)
    body.return_(n)
    with body.opening():
        body.descend(5)
    run = MachineCode(compile_module(module, effort), module.interface, deepest=10).function("deep")
    assert run(9) == 0
    for _ in range(3):
        with pytest.raises(MachineFault) as fault:
            run(10)
        assert (fault.value.number, fault.value.first) == (5, 0)
        assert run(9) == 0


def test_frame_bound_counts_what_is_kept_of_a_draft() -> None:
    body = ModuleBuilder().function("run", [I16], [I16], exported=True)
    empty = body.frame_bound
    with body.draft():
        body.variable(I16)
        body.buffer(100)
        body.return_(*body.parameters)
    assert body.frame_bound == empty
    body.buffer(100)
    assert body.frame_bound == empty + 104
    body.clear()
    assert body.frame_bound == empty


@pytest.mark.parametrize("is_own", [True, False])
def test_one_more_in_memory(several: Any, monkeypatch: pytest.MonkeyPatch, is_own: bool) -> None:
    if not is_own:
        monkeypatch.setattr(builder, "HAS_INCREMENT", False)

    def twice(body: B, base: Operand, index: Operand) -> Operand:
        before = body.load(I64, base, 8)
        body.increment(base, 8)
        body.increment(body.address(base, index, 8))
        return body.subtract(body.load(I64, base, 8), before)

    run = several({"twice": ([ADDRESS, I64], I64, twice)})
    memory = bytearray(struct.pack("<4q", 5, (1 << 62) - 1, -1, 9))
    assert run["twice"](address_of(memory), 2) == 1
    assert run["twice"](address_of(memory), 1) == 2
    assert struct.unpack("<4q", memory) == (5, (1 << 62) + 2, 0, 9)
