"""Machine code in memory: exported functions, notes, an object file loaded twice."""

import doctest
import gc
import io
import sys
import weakref
from typing import Any

import pytest

from achse.native import backend
from achse.native.backend import (
    F64,
    I16,
    I64,
    Effort,
    MachineCode,
    ModuleBuilder,
    address_of,
    compile_module,
    compiler_installed,
    identity,
    machine,
    object_file,
)
from achse.native.backend.module import MATH, ModuleInterface


def test_the_example_of_the_package_runs() -> None:
    failed, tried = doctest.testmod(backend)
    assert not failed
    assert tried


def halving() -> ModuleBuilder:
    module = ModuleBuilder()
    body = module.function("half", [F64], [F64], exported=True)
    body.return_(body.multiply(body.parameters[0], body.constant(F64, 0.5)))
    return module


def test_an_object_file_is_loaded_as_often_as_one_likes() -> None:
    module = halving()
    content = compile_module(module)
    assert content == compile_module(module.assembly())
    first, second = (MachineCode(content, module.interface) for _ in range(2))
    assert first.function("half")(3.0) == second.function("half")(3.0) == 1.5
    with pytest.raises(KeyError):
        first.function("third")
    assert first.plain_function("half").argtypes is not None


def test_each_copy_has_a_budget_of_its_own() -> None:
    module = ModuleBuilder()
    body = module.function("step", exported=True, faults=True)
    body.spend()
    content = compile_module(module, Effort.FAST)
    first, second = (MachineCode(content, module.interface) for _ in range(2))
    first.budget = second.budget = 5
    first.function("step")()
    assert (first.budget, second.budget) == (4, 5)


def test_a_module_without_budget_has_none() -> None:
    code = MachineCode(compile_module(halving()), halving().interface)
    code.budget = 5
    assert code.budget == 0
    assert code.notes == b""


def test_notes_go_with_the_code() -> None:
    module = halving()
    module.notes = b'"quotes", \x00 and \xff'
    assert MachineCode(compile_module(module), module.interface).notes == module.notes


def test_addresses_follow_one_another() -> None:
    memory = bytearray(4)
    assert address_of(memory, 3) == address_of(memory) + 3
    assert address_of(memoryview(memory)[1:]) == address_of(memory, 1)


def test_c_functions_do_what_python_does() -> None:
    module = ModuleBuilder()
    for name in MATH:
        parameters = [F64] * (2 if name in ("atan2", "fmod", "pow") else 1)
        body = module.function(name, parameters, [F64], exported=True)
        body.return_(body.math(name, *body.parameters))
    code = MachineCode(compile_module(module), module.interface)
    import math

    for name in MATH:
        arguments = (1.5, 0.75) if name in ("atan2", "fmod", "pow") else (0.75,)
        if name == "acosh":
            arguments = (1.75,)
        assert code.function(name)(*arguments) == getattr(math, name)(*arguments)


def test_a_missing_compiler_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiler_installed()
    assert identity() == identity()
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    assert not compiler_installed()


@pytest.mark.skipif(not object_file.is_supported(), reason="LLVM tells the processor here")
def test_facts_of_a_processor_may_end_without_an_empty_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for text in ("", "model\t\t: 7\nflags\t\t: fpu"):
        monkeypatch.setattr(machine, "open", lambda *_, **__: io.StringIO(text), raising=False)  # noqa: B023
        assert ("fpu" in machine._processor.__wrapped__().split()) == ("fpu" in text.split())


def test_where_memory_may_not_be_executed_there_is_no_compiler(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """LLVM does not see that it was refused: the first call ended the process."""
    content = compile_module("define i64 @one() { ret i64 1 }")
    monkeypatch.setattr(object_file, "_let_execute", lambda address, size: 13)
    once = (object_file.memory_may_be_executed, machine._may_execute)
    for each in once:
        each.cache_clear()
    try:
        if sys.platform == "linux":
            assert not compiler_installed()
            assert "this system refuses memory for machine code" in caplog.text
            with pytest.raises(
                object_file.ExecutableMemoryError, match="expected memory for machine code"
            ):
                MachineCode(content, ModuleInterface({}))
    finally:
        for each in once:
            each.cache_clear()


def test_numbers_are_cut_to_the_parameters() -> None:
    module = ModuleBuilder()
    body = module.function("same", [I16], [I16], exported=True)
    body.return_(*body.parameters)
    assert MachineCode(compile_module(module), module.interface).function("same")(65_535) == -1


def test_machine_code_is_unloaded_after_the_last_that_refers_to_it() -> None:
    module = ModuleBuilder()
    words = module.words("kept", 2)
    callback = module.callback("asked", [I64], [I64])
    body = module.function("both", [I64], [I64], exported=True, faults=True)
    (answer,) = body.call(callback, *body.parameters)
    body.return_(body.add(answer, body.load(I64, words, 8)))
    content = compile_module(module, Effort.FAST)

    class Host:
        code: MachineCode

        def answer_for(self, number: int) -> int:
            return 2 * number

    def loaded() -> tuple[weakref.ref[Any], weakref.ref[Host], Any, Any]:
        host = Host()
        host.code = code = MachineCode(content, module.interface, {"asked": host.answer_for})
        module_loaded = weakref.ref(code._loaded)
        return module_loaded, weakref.ref(host), code.plain_function("both"), code.words("kept")

    module_loaded, host, both, stored = loaded()
    gc.collect()
    stored[1] = 5
    assert both(4) == 13
    assert module_loaded() is not None
    del both
    gc.collect()
    assert module_loaded() is not None
    assert host() is not None, "a callback can be called as long as there is code"
    stored[1] = 6
    del stored
    gc.collect()
    assert (module_loaded(), host()) == (None, None)


def test_code_that_runs_is_not_unloaded() -> None:
    module = ModuleBuilder()
    callback = module.callback("asked", [], [I64])
    body = module.function("twice", [], [I64], exported=True, faults=True)
    (first,) = body.call(callback)
    (second,) = body.call(callback)
    body.return_(body.add(first, second))
    content = compile_module(module, Effort.FAST)
    running: list[Any] = []

    def answer() -> int:
        running.clear()  # nothing but the call itself refers to the code any more
        gc.collect()
        return 21

    running.append(
        MachineCode(content, module.interface, {"asked": answer}).plain_function("twice")
    )
    assert running[0]() == 42
