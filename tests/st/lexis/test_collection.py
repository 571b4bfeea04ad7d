"""When Python searches for garbage while sources are read, declared and checked."""

import gc
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.xml import parse_xml
from achse.st.project import load_project
from achse.st.syntax.parser import parse


@pytest.mark.parametrize("many", [1_000, 100_000])
def test_many_objects_made_while_collection_is_paused_count_as_old(
    many: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.st.lexis.collection._MANY", many)
    frozen, thresholds = gc.get_freeze_count(), gc.get_threshold()
    gc.set_threshold(1_000_000)  # Python's own searches make objects old too
    try:
        with collection_paused():
            assert not gc.isenabled()
            items = [[number] for number in range(10_000)]
        assert gc.isenabled()
        assert gc.get_freeze_count() == frozen
        is_old = any(item is items for item in gc.get_objects(generation=2))
    finally:
        gc.set_threshold(*thresholds)
    assert is_old is (many == 1_000 and not frozen)


MADE_AND_DROPPED = """
import gc, weakref
from achse.st.lexis import collection
class Loop:
    def __init__(self):
        self.itself = self
collection._MANY, collection._MOST_UNSEARCHED = 1_000, 5_000
gc.set_threshold(1_000_000)
dropped = [weakref.WeakSet() for _ in range(8)]
for each in dropped:
    with collection.collection_paused():
        each.update([Loop() for _ in range(2_000)])
print(len(dropped[0]))
"""


def test_cycles_that_are_made_and_dropped_do_not_pile_up() -> None:
    words = [sys.executable, "-c", MADE_AND_DROPPED]  # this process has frozen objects
    ran = subprocess.run(words, capture_output=True, text=True, check=True, timeout=600)
    assert int(ran.stdout) == 0


TEXT = "PROGRAM P VAR n : INT; END_VAR n := n + 1; END_PROGRAM\n"


@pytest.mark.parametrize(
    "work",
    [
        lambda folder: load_project(folder),
        lambda _: declare([parse(TEXT)]),
        lambda _: check(declare([parse(TEXT)])),
        lambda _: parse_xml(b"<a>" + b"<b>1</b>" * 2000 + b"</a>", "f"),
    ],
)
def test_python_does_not_search_while_sources_become_objects(
    work: Callable[[Path], object], tmp_path: Path
) -> None:
    for number in range(30):
        (tmp_path / f"{number}.st").write_text(TEXT.replace("P ", f"P{number} "))
    work(tmp_path)  # what is made once is there
    searches: list[str] = []
    before = gc.get_threshold()
    gc.set_threshold(50)  # each short step between two pauses would be seen

    def note(phase: str, _: object) -> None:
        searches.append(phase)

    gc.callbacks.append(note)
    try:
        gc.collect(0)
        searches.clear()
        work(tmp_path)
        passes = len(searches) // 2
    finally:
        gc.set_threshold(*before)
        gc.callbacks.remove(note)
    assert passes <= 2  # before it begins, and after it ended
    assert gc.isenabled()
