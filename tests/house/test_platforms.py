"""Names that Windows lacks are guarded; a station runs without them."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.house.as_windows import MODULES, NAMES

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


def test_names_that_windows_lacks_are_guarded(root: Path) -> None:
    open_ones = {}
    for path in sorted((root / "src").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        used = sorted(set(needs(ast.parse(text))))
        if used and not any(guard in text for guard in GUARDS):
            open_ones[str(path.relative_to(root))] = used
    assert open_ones == {}


@pytest.mark.skipif(sys.platform == "win32", reason="plays Windows on another system")
def test_a_station_serves_and_moves_without_what_windows_lacks(root: Path) -> None:
    """1.6 s of a processor for a fresh interpreter: nothing else tries these branches together."""
    words = [sys.executable, "-m", "tests.house.as_windows"]
    run = subprocess.run(words, cwd=root, capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (0, "1 mm\n"), run.stderr
