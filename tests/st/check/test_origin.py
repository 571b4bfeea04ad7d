"""Whatever a project follows from shows in its origin, and nothing else does."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

SOURCES = {
    "list.st": "VAR_GLOBAL CONSTANT\n nMost : INT := 5;\nEND_VAR\n",
    "types.st": "TYPE E_Step : (FIRST := 1, SECOND); END_TYPE\n",
    "main.st": "PROGRAM MAIN\nVAR n, e : INT; END_VAR\n"
    "{IF defined (fast)}\nn := nMost;\n{ELSE}\nn := -nMost;\n{END_IF}\n"
    "e := E_Step.SECOND + nGiven;\nEND_PROGRAM\n",
}


def _origin(*changes: tuple[str, str, str], predefined: int = 1) -> str:
    texts = dict(SOURCES)
    for file, old, new in changes:
        assert old in texts[file]
        texts[file] = texts[file].replace(old, new)
    sources = [parse(Source(text, path)) for path, text in texts.items()]
    return check(declare(sources, constants={"nGiven": predefined})).origin


def test_the_same_is_the_same() -> None:
    assert _origin() == _origin()


@pytest.mark.parametrize(
    "change",
    [
        ("list.st", ":= 5", ":= 6"),
        ("types.st", ":= 1", ":= 2"),
        ("main.st", "-nMost", "nMost"),
        ("main.st", "VAR n", "VAR  n"),
    ],
    ids=["constant", "enumeration", "body", "place"],
)
def test_a_change_of_a_source_shows(change: tuple[str, str, str]) -> None:
    assert _origin(change) != _origin()


def test_constants_that_are_handed_in_show() -> None:
    assert _origin(predefined=2) != _origin()
