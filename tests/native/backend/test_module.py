"""Modules: declared functions, data, and what is missing."""

import pytest

from achse.native.backend import F64, I16, InstructionError, ModuleBuilder


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
