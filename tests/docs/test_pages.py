"""README and every page of docs/ do what they say, when typed in from top to bottom."""

import os
import pkgutil
import re
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.site.hooks import generated_pages

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
LINK = re.compile(r"\]\((?!https?:)([^)#]+)(?:#[^)]*)?\)")

NAME = re.compile(r"`(achse(?!\.toml`)(?:\.\w+)+)(?:\(\))?`")
RUN = re.compile(r"^```(?:console|python)", re.MULTILINE)


def each(pages: list[Path]) -> pytest.MarkDecorator:
    names = [str(page.relative_to(ROOT)) for page in pages]
    return pytest.mark.parametrize("page", pages, ids=names)


@each([page for page in PAGES if RUN.search(page.read_text(encoding="utf-8"))])
def test_the_page_does_what_it_says(
    page: Path, read_page: Callable[[str, str], None], witness: Callable[[str], None]
) -> None:
    text = page.read_text(encoding="utf-8")
    signs = {
        "import pyads": "pyads",
        "```js": "ads-client",
        "import fmpy": "fmpy",
        "import gymnasium": "gymnasium",
        "$ achse fmu": "cc",
    }
    for sign, name in signs.items():
        if sign in text:
            witness(name)
    read_page(str(page.relative_to(ROOT)), text)


@each(PAGES)
def test_each_block_names_a_known_language(
    page: Path, fences: Callable[[str], list[Any]], languages: set[str]
) -> None:
    unknown = [
        f"line {block.line}: {block.language or 'nothing'}"
        for block in fences(page.read_text(encoding="utf-8"))
        if block.language not in languages
    ]
    assert unknown == []


@each(PAGES)
def test_each_link_leads_to_a_file(page: Path) -> None:
    """To one that is there, or to a page of docs/ that the site makes."""
    targets = LINK.findall(page.read_text(encoding="utf-8"))
    absent = [target for target in targets if not (page.parent / target).exists()]
    if absent:
        generated = {(ROOT / "docs" / name).resolve() for name in generated_pages()}
        absent = [target for target in absent if (page.parent / target).resolve() not in generated]
    assert absent == []


@each(PAGES)
def test_each_name_of_ours_exists(page: Path) -> None:
    """What is in backticks and begins with `achse.` can be imported, but the file `achse.toml`."""
    for name in set(NAME.findall(page.read_text(encoding="utf-8"))):
        pkgutil.resolve_name(name)


def test_ci_runs_the_test_command_of_the_readme() -> None:
    extraction = next(
        line for line in (ROOT / ".ci/run").read_text().splitlines() if line.startswith("tests=")
    )
    command = subprocess.run(
        ["bash", "-c", f'{extraction}; printf %s "$tests"'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert command in (ROOT / "README.md").read_text().splitlines()
    assert "pytest" in command


@pytest.mark.skipif(
    os.environ.get("ACHSE_WITNESSES") != "required",
    reason="installs from a package index; .ci/run asks for it",
)
def test_the_first_command_of_the_readme_starts_a_station(
    tmp_path: Path, free_host: Callable[[], str]
) -> None:
    lines = (ROOT / "README.md").read_text().splitlines()
    command = next(line for line in lines if line.endswith("/achse run"))
    subprocess.run(["git", "clone", "-q", ROOT, tmp_path / "clone"], check=True)
    host = free_host()
    with subprocess.Popen(
        ["bash", "-c", command],
        cwd=tmp_path / "clone",
        env=os.environ | {"ACHSE_HOST": host},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as shell:
        assert shell.stdout is not None
        ready = shell.stdout.readline()
        os.killpg(shell.pid, signal.SIGTERM)
    assert ready.startswith(f"achse ready net_id=127.0.0.1.1.1 tcp={host}:48898"), ready
