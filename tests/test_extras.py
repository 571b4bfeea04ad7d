"""Advice for a missing extra belongs to how this copy was installed."""

import importlib.metadata
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.extras import install_command, needs_extra, requirement_elsewhere

ROOT = Path(achse.__file__).parents[2]


class Installed:
    def __init__(self, origin: dict[str, Any] | None) -> None:
        self.origin = origin

    def read_text(self, name: str) -> str | None:
        assert name == "direct_url.json"
        return None if self.origin is None else json.dumps(self.origin)


@pytest.mark.parametrize(
    ("origin", "command"),
    [
        (None, 'pip install "achse[web]"'),
        (
            {"url": Path("/a b/clone").as_uri(), "dir_info": {}},
            f'pip install "{Path("/a b/clone")}[web]"',
        ),
        (
            {"url": Path("/clone").as_uri(), "dir_info": {"editable": True}},
            f'pip install -e "{Path("/clone")}[web]"',
        ),
        (
            {"url": "https://example.org/a.git", "vcs_info": {"vcs": "git", "commit_id": "1"}},
            'pip install "achse[web] @ git+https://example.org/a.git"',
        ),
        (
            {
                "url": "ssh://git@example.org/a.git",
                "vcs_info": {"vcs": "git", "requested_revision": "v1", "commit_id": "1"},
            },
            'pip install "achse[web] @ git+ssh://git@example.org/a.git@v1"',
        ),
        (
            {"url": "https://example.org/achse.whl", "archive_info": {}},
            'pip install "achse[web] @ https://example.org/achse.whl"',
        ),
    ],
)
def test_command_installs_from_where_the_copy_came_from(
    origin: dict[str, Any] | None, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: Installed(origin))
    assert install_command("web") == command
    assert needs_extra("the page", "web") == f"the page needs the extra web: {command}"


def test_tree_that_is_not_installed_is_installed_from_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def missing(_: str) -> Any:
        raise importlib.metadata.PackageNotFoundError

    monkeypatch.setattr(importlib.metadata, "distribution", missing)
    assert install_command("fast") == f'pip install -e "{ROOT}[fast]"'


def test_each_extra_that_is_advised_exists() -> None:
    """Every extra of a message is declared by the package."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = declared["optional-dependencies"]
    advised = {
        extra
        for path in (ROOT / "src").rglob("*.py")
        for extra in re.findall(
            r"needs_extra\((?:[^()]|\([^()]*\))*?[\"'](\w+)[\"']\)", path.read_text("utf-8")
        )
    }
    names = "docs fast fmu lsp mcp metrics mqtt plot secure serial sweep tables web"
    assert advised == set(names.split())
    assert advised <= extras.keys()


def test_no_other_place_advises_to_install() -> None:
    places = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "src").rglob("*.py")
        if "pip install" in path.read_text("utf-8")
    ]
    assert sorted(places) == ["src/achse/cli/start/new.py", "src/achse/extras.py"]


def test_page_on_installing_names_each_extra_for_users() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page = (ROOT / "docs" / "how-to" / "install.md").read_text(encoding="utf-8")
    named = re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)
    assert set(named) == project["optional-dependencies"].keys() - {"dev"}


@pytest.mark.parametrize(
    ("origin", "requirement", "is_reachable"),
    [
        (None, "achse[fast]", True),
        (
            {"url": "https://h/a.git", "vcs_info": {"vcs": "git", "requested_revision": "v1"}},
            "achse[fast] @ git+https://h/a.git@v1",
            True,
        ),
        ({"url": "file:///clone", "dir_info": {"editable": True}}, "achse[fast]", False),
    ],
)
def test_the_requirement_of_another_computer(
    origin: dict[str, Any] | None,
    requirement: str,
    is_reachable: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: Installed(origin))
    assert requirement_elsewhere("fast") == (requirement, is_reachable)
