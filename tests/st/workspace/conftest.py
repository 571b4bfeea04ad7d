"""The small project in a workspace."""

from pathlib import Path

import pytest

from achse.st.workspace import Workspace
from tests.st.workspace.sample import write_project


@pytest.fixture(scope="module")
def sample_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the sample project; nothing writes into it."""
    return write_project(tmp_path_factory.mktemp("sample"))


@pytest.fixture
def workspace(sample_folder: Path) -> Workspace:
    """The sample project, without edits."""
    return Workspace(sample_folder)
