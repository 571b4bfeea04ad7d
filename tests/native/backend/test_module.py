"""Modules: declared functions, data, and what is missing."""

import pytest

from achse.native.backend import (
    F64,
    I16,
    I64,
    InstructionError,
    MachineCode,
    ModuleBuilder,
    compile_module,
)


def test_a_declared_function_has_to_be_written() -> None:
    module = ModuleBuilder()
    module.declare("lost")
    with pytest.raises(InstructionError, match="'lost' is declared but was not written"):
        module.assembly()


def test_names_are_given_once() -> None:
    module = ModuleBuilder()
    module.declare("run")
    with pytest.raises(InstructionError, match="declared twice"):
        module.declare("run")
    module.callback("ask", [I16])
    with pytest.raises(InstructionError, match="callback 'ask'"):
        module.callback("ask", [F64])


def test_python_gets_one_result() -> None:
    with pytest.raises(InstructionError, match="one result"):
        ModuleBuilder().declare("run", [], [I16, I16], exported=True)


def test_equal_data_is_there_once() -> None:
    module = ModuleBuilder()
    assert module.data(b"ab") == module.data(b"ab") != module.data(b"b")
    assert module.assembly().count("private constant") == 2


def test_what_faults_brings_its_place() -> None:
    quiet, loud = ModuleBuilder(), ModuleBuilder()
    quiet.function("run")
    loud.function("run", faults=True)
    assert "@achse.fault" not in quiet.assembly()
    assert "@achse.fault" in loud.assembly()


def test_the_interface_is_what_python_sees() -> None:
    module = ModuleBuilder()
    module.function("own")
    run = module.function("run", [I16], exported=True)
    ask = module.callback("ask", [], [F64])
    assert module.interface.functions == {"run": run.function}
    assert module.interface.callbacks == {"ask": ask.signature}


def test_words_are_shared_and_tables_are_functions() -> None:
    module = ModuleBuilder()
    words = module.words("counts", 2)
    body = module.function("count", [], exported=True)
    body.store(body.add(body.load(I64, words, 8), body.constant(I64, 1)), words, 8)
    body.return_()
    module.table("all", [body.function, None])
    code = MachineCode(compile_module(module), module.interface)
    shared = code.words("counts")
    shared[1] = 41
    code.function("count")()
    assert list(shared) == [0, 42]
    first, second = code.table("all", 2)
    assert first != 0 == second
