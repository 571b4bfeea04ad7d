"""Names say the job, files stay short, nothing is left for later or tied to one machine."""

import ast
import re
from pathlib import Path

import pytest

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


def _text(root: Path, path: Path) -> str:
    try:
        return (root / path).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return ""


def test_no_file_or_folder_is_a_drawer(tracked: list[Path]) -> None:
    drawers = [
        str(path)
        for path in tracked
        if DRAWERS & {part.removeprefix("test_").partition(".")[0] for part in path.parts}
    ]
    assert drawers == []


def test_files_are_short(root: Path, tracked: list[Path]) -> None:
    long = {
        str(path): lines
        for path in tracked
        if path.suffix == ".py" and (lines := _text(root, path).count("\n")) > MAX_LINES
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
    root: Path, tracked: list[Path], pattern: re.Pattern[str], suffixes: set[str] | None
) -> None:
    found = [
        f"{path}:{number}: {line.strip()}"
        for path in tracked
        if suffixes is None or path.suffix in suffixes
        for number, line in enumerate(_text(root, path).splitlines(), 1)
        if pattern.search(line)
    ]
    assert not found, "\n".join(found)


KINDS = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
"""What a module offers under a name; constants are the module's own choice."""


def _exported(tree: ast.Module) -> set[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def test_public_names_are_declared(root: Path, modules: list[Path]) -> None:
    undeclared = {}
    for path in modules:
        if path.parts[2] == "cli":
            continue  # commands are called by their app, not imported
        tree = ast.parse((root / path).read_bytes())
        names = {node.name for node in tree.body if isinstance(node, KINDS)}
        if missing := {name for name in names - _exported(tree) if not name.startswith("_")}:
            undeclared[str(path)] = sorted(missing)
    assert not undeclared, f"public, but not in __all__: {undeclared}"


def test_each_module_begins_with_its_job(root: Path, modules: list[Path]) -> None:
    silent = [
        str(path)
        for path in modules
        if not (ast.get_docstring(ast.parse((root / path).read_bytes())) or "").strip()
    ]
    assert silent == []
