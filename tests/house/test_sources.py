"""Modules that hold facts of a manual, a standard or recorded traffic say where these come from."""

from pathlib import Path

from tests.house.sources import Module

ROOMS = ("ams", "codes", "ethercat", "iec", "st")
"""Rooms whose matter is given from outside."""

TO_COME = ("st/check", "st/lint", "st/typed", "st/symbolfiles", "st/workspace")
"""The checker, the linter, the typed form and the workspace rest on the syntax tree, whose modules
have their sources; symbol files name theirs where they are read."""

OURS = {
    "ams/connection.py": "the state of a stream is our own; frames have their source",
    "ams/errors.py": "our tree of errors",
    "codes/station.py": "the station's own service at port 26000",
    "codes/links.py": "how our documentation is ordered",
    "iec/documents.py": "how JSON has values is our choice",
    "iec/errors.py": "our tree of errors",
    "iec/nearest.py": "what a name may be meant for is our choice",
    "st/declared/block_layouts.py": "how private state lies behind an interface is our choice",
    "st/lexis/codes.py": "our codes of findings",
    "st/files/reading.py": "which text of a file counts is our choice",
    "st/lexis/collection.py": "when Python searches for garbage is our choice",
    "st/syntax/cursor.py": "a parser's own tool",
    "st/files/defines.py": "what a project declares, looked up",
    "st/declared/predefined.py": "puts together what others declare",
    "st/explanations/explanation.py": "how findings are explained is our choice",
    "st/graphical/body.py": "when a drawn body is read is our choice",
    "st/graphical/lowering.py": "calls the lowering of each language",
    "st/graphical/writer.py": "what lowerings write to",
    "st/formatting/layout.py": "where lines begin is our choice",
    "st/mentions.py": "which words of a body count as names is our choice",
    "st/syntax/nodes.py": "how trees are kept is our choice",
    "st/syntax/outlines.py": "what is listed of a unit is our choice",
    "st/syntax/printer.py": "the other way round of the parser",
    "st/project.py": "how a folder of sources is read is our choice",
    "st/reach.py": "what of a project is built is our choice (decision 0193)",
    "st/declared/records.py": "makes the types of achse.iec",
    "st/declared/resolve.py": "makes the types of achse.iec",
    "st/lexis/source.py": "how faults are shown is our choice",
    "st/declared/start_values.py": "when initial values are worked out is our choice",
    "st/lexis/xml.py": "a reader of XML",
}
"""Modules without a source, and why."""


def test_facts_name_their_source(parsed: dict[Path, Module]) -> None:
    silent = []
    for path, module in parsed.items():
        place = path.relative_to("src/achse").as_posix()
        if not place.startswith(tuple(f"{room}/" for room in ROOMS)):
            continue
        if path.name == "__init__.py" or place in OURS or place.startswith(TO_COME):
            continue
        if not any(sign in module.docstring for sign in ("Source", "§", "table ")):
            silent.append(place)
    assert not silent, f"no source in the docstring of: {', '.join(silent)}"


def test_the_exceptions_are_needed(root: Path) -> None:
    assert [name for name in OURS if not (root / "src" / "achse" / name).exists()] == []
