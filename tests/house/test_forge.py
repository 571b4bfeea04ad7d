"""Files for a forge: valid by its schemas, actions pinned, least rights; versions agree."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import achse

SCHEMAS = {
    "vendor.github-workflows": "workflows/*.yml",
    "vendor.dependabot": "dependabot.yml",
    "vendor.github-issue-config": "ISSUE_TEMPLATE/config.yml",
    "vendor.github-issue-forms": "ISSUE_TEMPLATE/[!c]*.yml",
}


def found_by(program: str, *arguments: str | Path) -> str:
    """What a checker prints if it is not content."""
    tool = Path(sys.executable).with_name(program)
    run = subprocess.run([str(tool), *map(str, arguments)], text=True, capture_output=True)
    return run.stdout + run.stderr if run.returncode else ""


@pytest.mark.parametrize("schema", SCHEMAS)
def test_the_forge_reads_each_file(root: Path, schema: str) -> None:
    files = sorted((root / ".github").glob(SCHEMAS[schema]))
    assert files
    assert not found_by("check-jsonschema", "--builtin-schema", schema, *files)


def test_workflows_have_least_rights(root: Path) -> None:
    assert not found_by("zizmor", "--offline", "--no-progress", "-q", root / ".github")


def test_actions_are_pinned_with_their_version(root: Path) -> None:
    for workflow in (root / ".github/workflows").glob("*.yml"):
        for used in re.findall(r"uses: (.*)", workflow.read_text(encoding="utf-8")):
            assert re.match(r"[\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", used), used


def test_the_citation_is_of_this_version(root: Path) -> None:
    path = root / "CITATION.cff"
    assert f"\nversion: {achse.__version__}\n" in path.read_text(encoding="utf-8")
    assert not found_by("check-jsonschema", "--builtin-schema", "vendor.citation-file-format", path)
