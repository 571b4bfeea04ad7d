"""Modules of machine code with one function of interest."""

import random
import struct
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from achse.native.backend import (
    BOOL,
    F32,
    F64,
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


def _drawn(type: MachineType, dice: random.Random) -> float:
    if type is F32:
        single: float = struct.unpack("<f", struct.pack("<f", _drawn(F64, dice) % 1e30))[0]
        return single
    if type.is_real:
        return dice.choice((0.0, -0.0, 1.5, -2.5, 3e9, -1e19, 1e300, dice.uniform(-300, 300)))
    if type is BOOL:
        return dice.random() < 0.5
    edges = (type.least, type.most, 0, 1, -1 if type.signed else 2, dice.randrange(70) % type.most)
    return dice.choice((*edges, dice.randint(type.least, type.most)))


@pytest.fixture(scope="session")
def drawn() -> Callable[[MachineType, random.Random], float]:
    """Draws a number of a type, often one at an edge."""
    return _drawn
