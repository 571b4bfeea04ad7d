"""What the checks on the project look at: its root, its tracked files, its modules."""

import subprocess
from pathlib import Path

import pytest

from achse.st.lexis.collection import collection_paused
from tests.house.sources import Module, Texts, read_module

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    """The project's root."""
    return ROOT


@pytest.fixture(scope="session")
def tracked(root: Path) -> list[Path]:
    """Every file of the project, relative to the root: what git tracks and has not deleted."""
    listing = subprocess.run(
        ["git", "ls-files", "-z"], cwd=root, capture_output=True, check=True, text=True
    )
    return [Path(name) for name in listing.stdout.split("\0") if name and (root / name).is_file()]


@pytest.fixture(scope="session")
def modules(tracked: list[Path]) -> list[Path]:
    """Every module of the package, relative to the root."""
    return [path for path in tracked if path.parts[0] == "src" and path.suffix == ".py"]


@pytest.fixture(scope="session")
def texts(root: Path) -> Texts:
    """`texts[path]`: the text of a tracked file; what is not text is empty."""
    return Texts(root)


@pytest.fixture(scope="session")
def parsed(modules: list[Path], texts: Texts) -> dict[Path, Module]:
    """What the checks ask of each module of the package; the tree is walked once per run."""
    with collection_paused():
        return {path: read_module(texts[path]) for path in modules}
