"""Recipes of the documentation are what `achse new project` writes, and linters find nothing."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.cli.start.new import GITHUB, GITLAB

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "run-in-ci.md"


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
    schema = ("check-jsonschema", "--builtin-schema")
    for number, (text, *command) in enumerate(
        (
            (github, *schema, "vendor.github-workflows"),
            (gitlab, *schema, "vendor.gitlab-ci"),
            (job, *schema, "vendor.gitlab-ci"),
            (commits, "pre-commit", "validate-config"),
        )
    ):
        file = tmp_path / f"{number}.yaml"
        file.write_text(text, encoding="utf-8")
        program = Path(sys.executable).with_name(command[0])
        if not program.exists():
            pytest.skip(f"{command[0]} is not installed; the extra `dev` has it")
        told = subprocess.run(
            [str(program), *command[1:], str(file)], capture_output=True, text=True
        )
        assert told.returncode == 0, told.stdout + told.stderr


def test_every_how_to_says_what_is_needed() -> None:
    silent = [
        page.name
        for page in sorted(PAGE.parent.glob("*.md"))
        if "\nYou need: " not in page.read_text(encoding="utf-8")
    ]
    assert not silent, f"begin with a paragraph `You need: …`: {', '.join(silent)}"
