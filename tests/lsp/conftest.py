"""A client whose server knows the small project."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.lsp.client import InProcessClient, opened
from tests.st.workspace.sample import write_project


@pytest.fixture(scope="session")
def project_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the sample project; nothing writes into it."""
    return write_project(tmp_path_factory.mktemp("lsp"))


@pytest.fixture
def client(project_folder: Path) -> Iterator[InProcessClient]:
    """A client of its own server."""
    with opened(project_folder) as one:
        yield one


@pytest.fixture(scope="session")
def reader(project_folder: Path) -> Iterator[InProcessClient]:
    """A client that opens and changes nothing."""
    with opened(project_folder) as one:
        yield one
