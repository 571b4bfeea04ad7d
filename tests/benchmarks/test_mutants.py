"""Faults that benchmarks/mutants.py plants: which there are, and that planted code behaves so."""

import importlib.util
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"

SOURCE = '''"""A module."""
MOST = 3
import logging
log = logging.getLogger("x")

class Gate:
    """A class."""

    def __repr__(self) -> str:
        return "a" if 1 < 2 else "b"

    def passes(self, width: int, height: int = 1) -> bool:
        """Return a truth."""
        assert width > -9, "not so small"
        log.info("width %d", width + 1)
        if width < 0:
            raise ValueError(f"{width + 1}")
        return width <= MOST and height - width < 2

def count(numbers: list[int]) -> int:
    seen: list[int] = []
    def note(number: int) -> None:
        seen.append(-number)
    bits = 0
    for number in numbers:
        note(number)
        bits |= number
    return len(seen)
'''


def imported(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"achse_mutants_{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def planter() -> Any:
    return imported(BENCHMARKS / "planter.py")


@pytest.fixture
def module(tmp_path: Path) -> Iterator[ModuleType]:
    file = tmp_path / "gates.py"
    file.write_text(SOURCE, encoding="utf-8")
    module = imported(file)
    yield module
    del sys.modules[module.__name__]


@pytest.fixture
def planted(planter: Any, module: ModuleType) -> Callable[[str], bool]:
    """`planted(change)` plants the fault whose change it is."""
    source = planter.Source(Path(str(module.__file__)))

    def plant(change: str) -> bool:
        [mutant] = [each for each in planter.mutants_of(source) if each.change == change]
        functions = planter.live_functions({str(module.__file__)})
        done: bool = planter.plant(source, mutant, functions)
        return done

    return plant


def test_all_faults_of_a_module(planter: Any, module: ModuleType) -> None:
    source = planter.Source(Path(str(module.__file__)))
    mutants = [(each.line, each.change) for each in planter.mutants_of(source)]
    assert mutants == [
        (2, "3 → 4"),
        (16, "0 → 1"),
        (16, "width < 0 → False"),
        (16, "width < 0 → width <= 0"),
        (18, "2 → 3"),
        (18, "height - width < 2 → height - width <= 2"),
        (18, "height - width → height + width"),
        (18, "width <= MOST and height - width < 2 → width <= MOST or height - width < 2"),
        (18, "width <= MOST → width < MOST"),
        (18, "without height - width < 2"),
        (18, "without width <= MOST"),
        (23, "-number → number"),
        (23, "without seen.append(-number)"),
        (24, "0 → 1"),
        (26, "without note(number)"),
        (27, "without bits |= number"),
    ]


def test_functions_can_be_chosen(planter: Any, module: ModuleType) -> None:
    source = planter.Source(Path(str(module.__file__)))
    assert {each.function for each in planter.mutants_of(source, ["count"])} == {
        "count",
        "count.<locals>.note",
    }
    assert not [m for m in planter.mutants_of(source, [], ["Gate.passes"]) if m.line in (16, 18)]


def test_a_fault_is_in_the_function_that_exists(planted: Any, module: Any) -> None:
    gate = module.Gate()
    with pytest.raises(ValueError, match="0"):
        gate.passes(-1)
    assert planted("width < 0 → False")
    assert not gate.passes(-1)


def test_a_fault_within_a_function_of_a_function(planted: Any, module: Any) -> None:
    assert module.count([1, 2]) == 2
    assert planted("without seen.append(-number)")
    assert module.count([1, 2]) == 0


def test_a_constant_has_the_other_value(planted: Any, module: Any) -> None:
    assert not module.Gate().passes(4)
    assert planted("3 → 4")
    assert module.Gate().passes(4)


def test_a_fault_stays_out_of_the_file(planted: Any, module: Any) -> None:
    assert planted("without note(number)")
    assert Path(module.__file__).read_text(encoding="utf-8") == SOURCE
