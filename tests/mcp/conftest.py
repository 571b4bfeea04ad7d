"""A folder with projects, for an agent."""

from pathlib import Path

import pytest

from tests.mcp.client import write_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_folder(tmp_path / "work")
