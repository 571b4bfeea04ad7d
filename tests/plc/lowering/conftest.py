"""Fixtures of lowering: programs in both forms of code, and the lowered form of their routines."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.code.execution import CodeForm
from achse.plc.lowering.nodes import LoweredRoutine
from achse.plc.lowering.placement import Placement
from achse.plc.lowering.project import LoweredProject
from achse.plc.lowering.routines import lowered
from tests.plc.code.conftest import Ran, bench, form, run

__all__ = ["bench", "form", "lower", "run"]


@pytest.fixture(scope="session")
def lower() -> Callable[..., LoweredRoutine]:
    """`lower(text, key)`: a routine of a source in the lowered form."""

    def lowered_routine(text: str, key: str = "main", **options: Any) -> LoweredRoutine:
        ran = Ran(text, CodeForm.PLAIN)
        project = LoweredProject(ran.typed, Placement(ran.plc.memory, ran.plc.variables))
        return lowered(project, ran.typed.routines[key], **options)

    return lowered_routine
