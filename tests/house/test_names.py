"""Names say the job, files stay short, nothing is left for later or tied to one machine."""

import re
from pathlib import Path

import pytest

from tests.house.public_face import ROOMS
from tests.house.sources import Module, Texts

DRAWERS = {"utils", "util", "helpers", "helper", "common", "manager", "managers", "misc", "tools"}
"""Names that hold anything and so say nothing."""

MAX_LINES = 600

LONGER: dict[str, str] = {}
"""Files above the limit, and why they are one thing."""

LATER = re.compile(r"\b(?:TO[D]O|FIX[M]E|XX[X])\b")

MACHINE = re.compile(
    r"(?<![\w.])/(?:home|root|work|workspace|Users)/\w"  # a directory of somebody's machine
    r"|https?://(?:[\w-]+\.)*(?:registry|proxy|mirror|index)s?\b"
)


def test_no_file_or_folder_is_a_drawer(tracked: list[Path]) -> None:
    drawers = [
        str(path)
        for path in tracked
        if DRAWERS & {part.removeprefix("test_").partition(".")[0] for part in path.parts}
        and "libraries" not in path.parts  # PLC libraries have the names of their makers: Util
    ]
    assert drawers == []


def test_files_are_short(texts: Texts, tracked: list[Path]) -> None:
    long = {
        str(path): lines
        for path in tracked
        if path.suffix == ".py" and (lines := texts[path].count("\n")) > MAX_LINES
    }
    assert long.keys() == LONGER.keys(), f"longer than {MAX_LINES} lines: {long}"


@pytest.mark.parametrize(
    ("pattern", "suffixes"),
    [
        pytest.param(LATER, {".py", ".toml", ".md"}, id="promise"),
        pytest.param(MACHINE, None, id="machine"),
    ],
)
def test_no_line_holds_a_promise_or_a_machine(
    texts: Texts, tracked: list[Path], pattern: re.Pattern[str], suffixes: set[str] | None
) -> None:
    lines = [
        f"{path}:{number}: {line.strip()}"
        for path in tracked
        if (suffixes is None or path.suffix in suffixes) and pattern.search(texts[path])
        for number, line in enumerate(texts[path].splitlines(), 1)
        if pattern.search(line)
    ]
    assert not lines, "\n".join(lines)


def test_only_what_people_import_from_has_a_list_of_its_names(parsed: dict[Path, Module]) -> None:
    rooms = {Path("src", *room.split(".")).with_suffix(".py") for room in ROOMS}
    modules = [
        str(path)
        for path, module in parsed.items()
        if module.exported and path.name != "__init__.py" and path not in rooms
    ]
    assert not modules, "__all__ stands in packages"


def test_packages_offer_what_they_define(parsed: dict[Path, Module]) -> None:
    undeclared = {}
    for path, module in parsed.items():
        public = {name for name in module.offered if not name.startswith("_")}
        if path.name == "__init__.py" and not public <= module.exported:
            undeclared[str(path)] = sorted(public - module.exported)
    assert not undeclared, f"public, but not in __all__: {undeclared}"


def test_each_module_begins_with_its_job(parsed: dict[Path, Module]) -> None:
    assert [str(path) for path, module in parsed.items() if not module.docstring] == []
