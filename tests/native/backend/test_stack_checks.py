"""Checks of the stack: any frames, called in any way on stacks of any size, end with a fault."""

import ctypes
import threading
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.native.backend import (
    F64,
    I16,
    I64,
    U8,
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
    compile_module,
)
from achse.native.backend.stack_checks import UNCHECKED
from achse.native.backend.thread_stack import reserve_of
from tests.native.backend.stacks import in_thread

T = TypeVar("T")
KB = 1 << 10
TOO_DEEP = 77


class Frame(NamedTuple):
    """What a function of a recursion has on its stack."""

    parameters: list[MachineType]
    results: int
    variables: int
    buffers: list[int]
    values: int
    """Computed before the call and used after it: they are spilled."""
    conversions: int
    """From float to integer, which take more than an instruction each."""
    exported: bool


FRAMES = st.builds(
    Frame,
    st.lists(st.sampled_from([U8, I16, I64, F64]), max_size=40),
    st.integers(1, 5),
    st.one_of(st.integers(0, 20), st.sampled_from([500, 4000])),
    st.lists(st.integers(0, 20_000), max_size=3),
    st.one_of(st.integers(0, 10), st.integers(0, 150)),
    st.integers(0, 30),
    st.booleans(),
)
SIZES = st.sampled_from([128 * KB, 256 * KB, 1024 * KB, 8192 * KB])


def written(frames: list[Frame], callback_every: int = 0) -> ModuleBuilder:
    """Functions that call each other in turn, `n` calls deep: the first one gives 3 * n."""
    module = ModuleBuilder()
    callback = module.callback("asked", [I64], [I64])
    targets = []
    for number, frame in enumerate(frames):
        exported = frame.exported
        results = 1 if exported else frame.results
        targets.append(
            module.declare(f"f{number}", [I64, *frame.parameters], [I64] * results,
                           exported=exported, faults=True)
        )  # fmt: skip
    for number, frame in enumerate(frames):
        body = module.write(targets[number])
        body.will_descend()
        n, *operands = body.parameters
        after = targets[(number + 1) % len(frames)]
        asks = bool(callback_every) and number % callback_every == 0
        _body(body, frame, n, operands, after, callback if asks else None)
        with body.opening():
            body.descend(TOO_DEEP)
    run = module.function("run", [I64], [I64], exported=True, faults=True)
    first = targets[0]
    rest = [_zero(run, each) for each in first.signature.parameters[1:]]
    run.return_(run.call(first, *run.parameters, *rest)[0])
    return module


def _zero(body: FunctionBuilder, type: MachineType) -> Operand:
    return body.constant(type, 0.0 if type.is_real else 0)


def _body(
    body: FunctionBuilder, frame: Frame, n: Operand, operands: list[Operand], after: Any,
    callback: Any,
) -> None:  # fmt: skip
    zero, one, three = (body.constant(I64, number) for number in (0, 1, 3))
    variables = [body.variable(I64) for _ in range(frame.variables)]
    buffers = [body.buffer(size) for size in frame.buffers]
    more, end = body.label(), body.label()
    body.branch(body.compare(Relation.GREATER, n, zero), more, end)
    body.begin(more)
    for variable in variables[:: max(len(variables) // 10, 1)]:
        body.set(variable, n)
    for buffer, size in zip(buffers, frame.buffers, strict=True):
        body.fill(buffer, body.constant(U8, 7), size)
    values = [body.multiply(n, body.constant(I64, number)) for number in range(frame.values)]
    values += [
        body.convert(body.add(body.convert(n, F64), body.constant(F64, number / 2)), I64)
        for number in range(frame.conversions)
    ]
    below = body.subtract(n, one)
    if callback is not None:
        (below,) = body.call(callback, below)
    rest = [_zero(body, type) for type in after.signature.parameters[1:]]
    result, *_ = body.call(after, below, *rest)
    total = body.add(result, three)
    for value in values:
        total = body.bit_xor(total, value)
    for value in reversed(values):
        total = body.bit_xor(total, value)
    body.return_(*[total] * len(body.function.signature.results))
    body.begin(end)
    body.return_(*[zero] * len(body.function.signature.results))
    assert operands is not None


def outcome(run: Callable[[int], int], n: int) -> int | str:
    """The result, or that the calls are too deep."""
    try:
        return run(n)
    except MachineFault as fault:
        is_too_deep = fault.number in (TOO_DEEP, OwnFault.TOO_DEEP)
        return "too deep" if is_too_deep else str(fault)


@settings(max_examples=10)
@given(
    st.lists(FRAMES, min_size=1, max_size=4),
    st.lists(st.tuples(SIZES, st.integers(0, 5_000)), min_size=1, max_size=4),
    st.integers(0, 3),
    st.sampled_from([10, 1000, 100_000]),
)
def test_recursion_ends_by_result_or_fault_on_any_stack(
    frames: list[Frame], calls: list[tuple[int, int]], callback_every: int, deepest: int
) -> None:
    module = written(frames, callback_every)
    code = MachineCode(
        compile_module(module, Effort.FAST),
        module.interface,
        {"asked": lambda n: n},
        deepest=deepest,
    )
    run = code.function("run")
    bounds = [body.frame_bound for body in module._bodies]
    for size, n in calls:
        reached = in_thread(size, lambda n=n: outcome(run, n))  # type: ignore[misc]
        used = sum(bounds) * (n // len(frames) + 1)
        if n >= deepest:
            assert reached == "too deep"
        elif used < size - reserve_of(size) - 48 * KB:
            assert reached == 3 * n
        else:
            assert reached in ("too deep", 3 * n)
    assert outcome(run, 0) == 0


@given(FRAMES, st.sampled_from(Effort))
def test_frames_are_not_larger_than_their_bound(frame: Frame, effort: Effort) -> None:
    module = written([frame])
    guard = module._bodies[0].guard
    if guard is None:
        assert module._bodies[0].frame_bound <= UNCHECKED
        return
    text = module.assembly().replace(f"{guard.frame} = internal", f"{guard.frame} =")
    code = MachineCode(compile_module(text, effort), module.interface, {"asked": lambda n: n})
    place = code._address_of(guard.frame[1:].strip('"'))
    measured = ctypes.c_int64.from_address(place).value
    assert 0 < measured < guard.bound
    if effort is Effort.FAST:
        assert measured >= 8 * frame.variables + sum(frame.buffers)


def test_small_functions_have_no_guard() -> None:
    module = written([Frame([I64], 1, 10, [64], 5, 0, False)])
    assert module._bodies[0].guard is None
    assert "achse.measure" not in module.assembly()


@pytest.mark.parametrize("frame", [Frame([], 1, 16_384, [], 0, 0, False),
                                   Frame([I64], 2, 0, [600 * KB], 9, 9, True)])  # fmt: skip
def test_a_frame_larger_than_the_stack_is_a_fault_at_once(frame: Frame) -> None:
    module = written([frame])
    code = MachineCode(
        compile_module(module, Effort.FAST), module.interface, {"asked": lambda n: n}
    )
    run = code.function("run")
    size = module._bodies[0].frame_bound
    assert in_thread(128 * KB, lambda: outcome(run, 512 * KB // size)) == "too deep"
    most = (16 * 1024 * KB - 1024 * KB - 64 * KB) // size - 1
    assert in_thread(16 * 1024 * KB, lambda: outcome(run, most)) == 3 * most
    assert in_thread(16 * 1024 * KB, lambda: outcome(run, 64 * 1024 * KB // size)) == "too deep"


def test_a_call_from_another_thread_during_a_callback_keeps_the_limits() -> None:
    """A debugger holds a cycle in its own thread, and the station calls the same code."""
    module = written([Frame([], 1, 400, [], 0, 0, False)], callback_every=1)
    seen: list[int | str] = []

    def callback(n: int) -> int:
        if n == 500:
            seen.append(in_thread(256 * KB, lambda: outcome(run, 400)))
            seen.append(in_thread(8192 * KB, lambda: outcome(run, 400)))
        return n

    content = compile_module(module, Effort.FAST)
    run = MachineCode(content, module.interface, {"asked": callback}).function("run")
    for size, reached in ((4096 * KB, 1800), (256 * KB, "too deep"), (4096 * KB, 1800)):
        seen.clear()
        assert in_thread(size, lambda: outcome(run, 600)) == reached
        if reached == 1800:
            assert seen == ["too deep", 1200]


def test_stack_of_unknown_bounds_ends_below_the_first_call(monkeypatch: pytest.MonkeyPatch) -> None:
    from achse.native.backend import thread_stack

    module = written([Frame([], 1, 100, [], 0, 0, False)])
    code = MachineCode(
        compile_module(module, Effort.FAST), module.interface, {"asked": lambda n: n}
    )
    run = code.function("run")
    monkeypatch.setattr(thread_stack, "_bounds_by_system", lambda _: None)
    assert in_thread(8192 * KB, lambda: outcome(run, 20)) == 60
    assert outcome(run, 20) == 60
    assert in_thread(8192 * KB, lambda: outcome(run, 900)) == "too deep"


def test_frames_stay_at_their_bound_where_no_thread_can_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = written([Frame([], 1, 0, [600 * KB], 0, 0, False)])
    content = compile_module(module, Effort.FAST)

    def refused(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    before = threading.stack_size()
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refused)
        code = MachineCode(content, module.interface, {"asked": lambda n: n})
    assert threading.stack_size() == before
    run = code.function("run")
    assert in_thread(8192 * KB, lambda: outcome(run, 3)) == 9
    assert in_thread(128 * KB, lambda: outcome(run, 3)) == "too deep"


def test_a_frame_too_large_to_be_measured_is_refused() -> None:
    module = written([Frame([], 1, 0, [31 << 20], 0, 0, False)])
    with pytest.raises(InstructionError, match="frame of 31457280 bytes at most expected"):
        module.assembly()
