"""Names that Windows lacks are guarded; a station runs without them."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.house.as_windows import MODULES, NAMES
from tests.house.sources import Texts

OWNERS = "|".join(module.__name__ for module in NAMES)
MEMBERS = "|".join(name for names in NAMES.values() for name in names)
LACKING = re.compile(rf"\b(?:{'|'.join(MODULES)}|(?:{OWNERS})\s*\.\s*(?:{MEMBERS}))\b")
"""What a text has that needs a look at its syntax tree."""

GUARDS = ("sys.platform", "os.name", "hasattr(", "getattr(", "except ImportError")


def needs(tree: ast.Module) -> Iterator[str]:
    """Yield the names that Windows lacks and a module uses."""
    lacking = {module.__name__: names for module, names in NAMES.items()}
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(ast.Name(owner), name) if name in lacking.get(owner, ()):
                yield f"{owner}.{name}"
            case ast.Import(names):
                yield from (each.name for each in names if each.name in MODULES)
            case ast.ImportFrom(str(module)) if module in MODULES:
                yield module


def test_names_that_windows_lacks_are_guarded(modules: list[Path], texts: Texts) -> None:
    open_ones = {}
    for path in modules:
        text = texts[path]
        if any(guard in text for guard in GUARDS) or not LACKING.search(text):
            continue
        if used := sorted(set(needs(ast.parse(text)))):
            open_ones[str(path)] = used
    assert open_ones == {}


@pytest.mark.skipif(sys.platform == "win32", reason="plays Windows on another system")
def test_a_station_serves_and_moves_without_what_windows_lacks(root: Path) -> None:
    """1.6 s of a processor for a fresh interpreter: nothing else tries these branches together."""
    words = [sys.executable, "-m", "tests.house.as_windows"]
    run = subprocess.run(words, cwd=root, capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (0, "1 mm\n"), run.stderr
