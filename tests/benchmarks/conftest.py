"""Benchmarks run by a warm Python: their short forms are short, and starts would be the most."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.warm_commands import is_supported
from tests.warm_python import serving

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="session")
def warm_python(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The path of a `python` that is forked, or of the real one."""
    if not is_supported():
        yield sys.executable
        return
    with serving(tmp_path_factory.mktemp("python")) as folder:
        yield str(folder / "python")


@pytest.fixture(scope="session")
def run_benchmark(warm_python: str) -> Callable[..., str]:
    """`run_benchmark(name, *arguments)`: what the benchmark prints; it ends with code 0.

    It is forked, and what it starts with this Python is too. With `real=True` all are new
    interpreters: what starts in a network namespace of its own, and what measures starts.
    """

    def run(name: str, *arguments: str, real: bool = False) -> str:
        python = sys.executable if real else warm_python
        finished = subprocess.run(
            [python, str(BENCHMARKS / name), *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        assert finished.returncode == 0, finished.stdout + finished.stderr
        assert "Traceback" not in finished.stderr, finished.stderr
        return finished.stdout

    return run
