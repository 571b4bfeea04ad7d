"""Modules of machine code with one function of interest."""

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from achse.native.backend import (
    Effort,
    FunctionBuilder,
    MachineCode,
    MachineType,
    ModuleBuilder,
    Operand,
    compile_module,
)

Write = Callable[..., Operand | None]


@pytest.fixture(params=Effort, ids=lambda effort: effort.name.lower())
def effort(request: pytest.FixtureRequest) -> Effort:
    """Each way to compile."""
    chosen: Effort = request.param
    return chosen


@pytest.fixture
def load(effort: Effort) -> Callable[..., MachineCode]:
    """Makes machine code of a module."""

    def make(module: ModuleBuilder, **callbacks: Callable[..., Any]) -> MachineCode:
        return MachineCode(compile_module(module, effort), module.interface, callbacks)

    return make


@pytest.fixture
def several(load: Any) -> Callable[..., dict[str, Callable[..., Any]]]:
    """Makes functions by name: parameters, result and who writes the body."""

    def make(
        wanted: dict[str, tuple[Sequence[MachineType], MachineType | None, Write]],
    ) -> dict[str, Callable[..., Any]]:
        module = ModuleBuilder()
        for name, (parameters, result, write) in wanted.items():
            results = () if result is None else (result,)
            body: FunctionBuilder = module.function(name, parameters, results, exported=True)
            value = write(body, *body.parameters)
            body.return_(*(() if value is None else (value,)))
        code = load(module)
        return {name: code.function(name) for name in wanted}

    return make
