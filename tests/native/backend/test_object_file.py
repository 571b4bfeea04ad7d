"""Object files that are loaded without LLVM do what they do with it."""

import math
import os
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.backend import F64, I64, Effort, MachineCode, ModuleBuilder, compile_module
from achse.native.backend import object_file as loading
from achse.native.backend.module import MATH
from achse.native.backend.object_file import ObjectFile, ObjectFileError, is_supported

pytest.importorskip("llvmlite")

TWO = ("atan2", "fmod", "pow")


def everything() -> ModuleBuilder:
    """Return a module with all that object files have: calls in it and outside, data, words."""
    module = ModuleBuilder()
    requested = module.callback("asked", [I64], [I64])
    words = module.words("kept", 3)
    content = module.data(bytes(range(16)))
    for name in MATH:
        body = module.function(name, [F64] * (1 + (name in TWO)), [F64], exported=True)
        body.return_(body.math(name, *body.parameters))
    inner = module.function("inner", [I64], [I64], faults=True)
    (answer,) = inner.call(requested, *inner.parameters)
    inner.return_(inner.add(answer, inner.load(I64, content, 8)))
    body = module.function("outer", [I64], [I64], exported=True, faults=True)
    (answer,) = body.call(inner.function, *body.parameters)
    body.store(answer, words, 16)
    body.return_(body.add(answer, body.load(I64, words)))
    module.table("functions", [inner.function, None])
    module.notes = b"notes"
    return module


def outside(name: str) -> int:
    """No function is known."""
    return 0


@pytest.fixture(params=[True, False], ids=["alone", "by LLVM"])
def loaded(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Load object files with LLVM and without."""
    if request.param and not is_supported():
        pytest.skip("LLVM loads all object files here")
    monkeypatch.setattr(loading, "is_supported", lambda: request.param)


@pytest.mark.usefixtures("loaded")
@pytest.mark.parametrize("effort", Effort)
def test_both_ways_of_loading_do_the_same(effort: Effort) -> None:
    module = everything()
    content = compile_module(module, effort)
    requests: dict[str, Callable[..., Any]] = {"asked": lambda number: 3 * number}
    first, second = (MachineCode(content, module.interface, requests) for _ in range(2))
    for name in MATH:
        arguments = (1.5, 0.75) if name in TWO else (1.75 if name == "acosh" else 0.75,)
        assert first.function(name)(*arguments) == getattr(math, name)(*arguments)
    first.words("kept")[0] = 1000
    bytes_8_to_15 = int.from_bytes(bytes(range(8, 16)), "little")
    assert first.function("outer")(5) == 1015 + bytes_8_to_15
    assert list(first.words("kept")) == [1000, 0, 15 + bytes_8_to_15]
    assert list(second.words("kept")) == [0, 0, 0]
    assert first.table("functions", 2)[0] != 0
    assert first.table("functions", 2)[1] == 0
    assert first.notes == b"notes"


@pytest.mark.usefixtures("loaded")
def test_forked_processes_have_words_of_their_own() -> None:
    module = everything()
    code = MachineCode(compile_module(module), module.interface, {"asked": lambda number: number})
    words = code.words("kept")
    child = os.fork()
    if child == 0:
        words[0] = 7
        os._exit(0)
    os.waitpid(child, 0)
    assert words[0] == 0


@pytest.mark.skipif(not is_supported(), reason="LLVM loads all object files here")
def test_a_file_that_needs_an_unknown_function_is_refused() -> None:
    content = compile_module(everything())
    with pytest.raises(ObjectFileError, match="expected a function outside, 'achse_"):
        ObjectFile(content, outside)


@pytest.mark.skipif(not is_supported(), reason="LLVM loads all object files here")
@given(st.data())
def test_a_part_of_a_file_is_refused(data: st.DataObject) -> None:
    content = CONTENT
    size = data.draw(st.integers(0, len(content) - 1))
    with pytest.raises(ObjectFileError, match="expected"):
        ObjectFile(content[:size], outside)
    with pytest.raises(ObjectFileError, match="expected"):
        ObjectFile(data.draw(st.binary(max_size=200)), outside)


CONTENT = compile_module("define i64 @one() { ret i64 1 }") if is_supported() else b""
