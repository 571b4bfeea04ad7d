"""Functions as machine code, with a cache of their own."""

import importlib.util
import itertools
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pytest

from achse.native.compiled import Kernel
from achse.native.declare import RecordLayout

NUMBER = itertools.count()


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache directory for the tests of one module."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("cache")
        patch.setenv("ACHSE_CACHE_DIR", str(folder))
        yield folder


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., ModuleType]:
    """Makes a module of a source text; names given are there as well."""

    def write(text: str, **names: object) -> ModuleType:
        path = tmp_path_factory.mktemp("source") / f"written_{next(NUMBER)}.py"
        path.write_text(text, encoding="utf-8")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        vars(module).update(names)
        sys.modules[path.stem] = module
        spec.loader.exec_module(module)
        return module

    return write


@pytest.fixture(scope="module")
def compiled() -> Callable[..., Callable[..., Any]]:
    """Makes machine code of a function."""

    def make(
        function: FunctionType, layouts: Mapping[type, RecordLayout[Any]] | None = None
    ) -> Any:
        return Kernel("test", function, layouts or {}).function

    return make
