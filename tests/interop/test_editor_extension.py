"""The extension for VS Code: its own tests, with the messages that its client sends to `achse lsp`
and `achse plc debug`, and its package from one command."""

import json
import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from tests.warm_commands import WarmCommands

FOLDER = Path(__file__).parents[2] / "packaging" / "vscode"

pytestmark = pytest.mark.skipif(
    shutil.which("npm") is None or not (FOLDER / "node_modules").is_dir(),
    reason="npm install --prefix packaging/vscode brings what it is built with",
)


def _npm(folder: Path, script: str, achse: Path | None = None) -> str:
    words = json.dumps([str(achse)])
    done = subprocess.run(
        ["npm", "run", script],
        cwd=folder,
        env={**os.environ, "ACHSE": words},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The extension in a folder of its own, since building it writes there."""
    place = tmp_path / "vscode"
    shutil.copytree(FOLDER, place, ignore=shutil.ignore_patterns("node_modules", "out", "*.vsix"))
    (place / "node_modules").symlink_to(FOLDER / "node_modules")
    return place


def test_extension_speaks_with_server_and_debugger(copy: Path, warm_commands: WarmCommands) -> None:
    output = _npm(copy, "test", warm_commands.folder / "achse")
    assert "not ok" not in output
    assert "ok 10" in output
    assert "# SKIP" not in output


def test_package_has_what_runs_and_nothing_else(copy: Path) -> None:
    _npm(copy, "package")
    with zipfile.ZipFile(copy / "achse.vsix") as archive:
        names = {name.removeprefix("extension/") for name in archive.namelist()}
    assert {"out/extension.js", "package.json", "iecst.tmLanguage.json"} <= names
    assert not any(name.endswith(".ts") or "node_modules" in name for name in names)
