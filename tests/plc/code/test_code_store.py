"""Compiled routines are kept by their sources, and do what they did."""

import marshal
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.code.code_store import CodeStore

SOURCES = st.lists(
    st.tuples(st.integers(0, 9), st.lists(st.integers(1, 9), min_size=2, max_size=2)),
    min_size=1,
    max_size=6,
    unique_by=lambda each: each[0],
)


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ACHSE_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


def compile_text(text: str, places: tuple[int, ...]) -> CodeType:
    module = compile(text, "", "exec")
    return next(each for each in module.co_consts if isinstance(each, CodeType))


def refuse(text: str, places: tuple[int, ...]) -> CodeType:
    raise AssertionError(f"compiled again: {text}")


def results(
    store: CodeStore,
    sources: list[tuple[int, list[int]]],
    make: Callable[[str, tuple[int, ...]], CodeType],
) -> list[int]:
    values = []
    for number, places in sources:
        text = f"def f():\n return {number} * 7"
        code = store.code(text, tuple(places), make)
        values.append(FunctionType(code, {})())
    return values


@settings(max_examples=25)
@given(SOURCES, SOURCES)
def test_codes_are_kept_until_others_are_used(
    first: list[tuple[int, list[int]]], second: list[tuple[int, list[int]]]
) -> None:
    for sources in (first, second):
        store = CodeStore(["a.st", "b.st"])
        assert results(store, sources, compile_text) == [7 * number for number, _ in sources]
        store.save()
        again = CodeStore(["b.st", "a.st"])
        assert results(again, sources, refuse) == [7 * number for number, _ in sources]
        again.save()
    gone = [each for each in first if each not in second]
    with pytest.raises(AssertionError, match="compiled again"):
        results(CodeStore(["a.st", "b.st"]), [*gone, (100, [1, 1])], refuse)


def test_other_files_have_other_codes() -> None:
    store = CodeStore(["c.st"])
    results(store, [(1, [1, 1])], compile_text)
    store.save()
    with pytest.raises(AssertionError, match="compiled again"):
        results(CodeStore(["c.st", "d.st"]), [(1, [1, 1])], refuse)


@pytest.mark.parametrize("content", [b"", b"x", marshal.dumps([1]), marshal.dumps({b"": 3})])
def test_what_is_not_of_codes_is_made_again(content: bytes) -> None:
    store = CodeStore(["c.st"])
    store._file.save(content)
    again = CodeStore(["c.st"])
    assert results(again, [(3, [1, 2])], compile_text) == [21]
