"""Recipes of the documentation are what `achse new` writes, and linters find nothing."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.start.new import GITHUB, GITLAB
from tests.json_schemas import complaints

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "run-in-ci.md"
LINT = ROOT / "docs" / "how-to" / "lint-your-plc-code.md"
HOOKS = ROOT / ".pre-commit-hooks.yaml"


def test_each_recipe_is_yaml(fences: Any) -> None:
    yaml = pytest.importorskip("yaml")
    recipes = [block.body for block in fences(PAGE.read_text(encoding="utf-8"))]
    assert len(recipes) == 4
    assert all(isinstance(yaml.safe_load(recipe), dict) for recipe in recipes)
    released = [
        text.replace("{note}", "").replace("{achse}", "achse[fast]") for text in (GITHUB, GITLAB)
    ]
    assert recipes[:2] == released


def test_linters_find_nothing(fences: Any, tmp_path: Path) -> None:
    """By the schemas of the servers that check-jsonschema brings, and pre-commit itself."""
    github, gitlab, commits, script = (
        block.body for block in fences(PAGE.read_text(encoding="utf-8"))
    )
    job = "tests:\n" + "".join(f"  {line}\n" for line in script.splitlines())
    recipes = (github, "vendor.github-workflows"), (gitlab, "vendor.gitlab-ci")
    _valid(tmp_path, *recipes, (job, "vendor.gitlab-ci"))
    hook = tmp_path / "hook.yaml"
    hook.write_text(commits, encoding="utf-8")
    _accepted(hook, "pre-commit", "validate-config")


def _valid(folder: Path, *recipes: tuple[str, str]) -> None:
    """Check texts by their schemas."""
    for number, (text, schema) in enumerate(recipes):
        file = folder / f"{number}.yaml"
        file.write_text(text, encoding="utf-8")
        assert not complaints(schema, file)


def _accepted(file: Path, *command: str) -> None:
    """Check a file by a program of the extra `dev`."""
    program = Path(sys.executable).with_name(command[0])
    if not program.exists():
        pytest.skip(f"{command[0]} is not installed; the extra `dev` has it")
    result = subprocess.run([str(program), *command[1:], str(file)], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_linters_find_nothing_in_reports_of_findings(fences: Any, tmp_path: Path) -> None:
    *servers, commits = (
        block.body for block in fences(LINT.read_text(encoding="utf-8")) if block.language == "yaml"
    )
    schemas = ("vendor.github-workflows", "vendor.gitlab-ci", "vendor.azure-pipelines")
    _valid(tmp_path, *zip(servers, schemas, strict=True))
    hook = tmp_path / "hook.yaml"
    hook.write_text(commits, encoding="utf-8")
    _accepted(hook, "pre-commit", "validate-config")


def test_the_hook_is_valid_and_checks_a_project(tmp_path: Path) -> None:
    yaml = pytest.importorskip("yaml")
    _accepted(HOOKS, "pre-commit", "validate-manifest")
    (hook,) = yaml.safe_load(HOOKS.read_text(encoding="utf-8"))
    for name in ("MAIN.st", "plc/FB_Motor.TcPOU", "a.plcproj", "achse.toml", "station.toml"):
        assert re.search(hook["files"], name)
    assert not re.search(hook["files"], "README.md")
    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN\nEND_PROGRAM\n")
    program, *words = hook["entry"].split()
    assert program == "achse"
    assert CliRunner().invoke(app, [*words, str(tmp_path)]).exit_code == 0
    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN\nn := 1;\nEND_PROGRAM\n")
    assert CliRunner().invoke(app, [*words, str(tmp_path)]).exit_code == 1


def test_every_how_to_says_what_is_needed() -> None:
    silent = [
        page.name
        for page in sorted(PAGE.parent.glob("*.md"))
        if "\nYou need: " not in page.read_text(encoding="utf-8")
    ]
    assert not silent, f"begin with a paragraph `You need: …`: {', '.join(silent)}"
