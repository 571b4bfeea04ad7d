"""The changelog describes the version on one page; what users see is listed."""

import re
from pathlib import Path

import pytest

import achse
from tests.house.public_face import LISTED, public_face

HOW_TO = Path("docs/how-to")
LONGEST_SECTION = 100
"""Lines of a version, at most: one page."""


@pytest.fixture(scope="module")
def changelog(root: Path) -> str:
    return (root / "CHANGELOG.md").read_text(encoding="utf-8")


def test_what_users_see_is_listed() -> None:
    listed = LISTED.read_text(encoding="utf-8").splitlines()
    now = public_face()
    gone = [f"- {line}" for line in listed if line not in now]
    new = [f"+ {line}" for line in now if line not in listed]
    assert not gone + new, (
        "what users see differs from tests/data/public_face.txt: call "
        "`python -m tests.house.public_face`, and keep CHANGELOG.md true\n" + "\n".join(gone + new)
    )


def test_the_changelog_begins_with_this_version_on_one_page(changelog: str) -> None:
    newest = changelog.split("\n## ")[1]
    heading = newest.partition("\n")[0]
    assert heading.split()[0] == achse.__version__, heading
    assert len(newest.splitlines()) <= LONGEST_SECTION


def test_the_changelog_names_each_command(changelog: str) -> None:
    """`achse bus` for all commands below it; the second of two in one line without `achse`."""
    lines = (line.split() for line in public_face() if line.startswith("command "))
    commands = {words[2] for words in lines}
    named = set(re.findall(r"`(?:achse )?([a-z-]+)[^`]*`", changelog))
    assert commands - named == set()


def test_the_changelog_links_each_how_to_page(changelog: str, root: Path) -> None:
    pages = {path.relative_to(root).as_posix() for path in (root / HOW_TO).glob("*.md")}
    linked = set(re.findall(r"\]\(([^)#]+)", changelog))
    assert pages, "no how-to page found"
    assert pages - linked == set()


def test_no_text_holds_marks_of_a_merge(root: Path, tracked: list[Path]) -> None:
    marks = re.compile(r"<{7} |>{7} ")
    pages = [path for path in tracked if path.suffix in (".md", ".toml", ".yml", ".st", ".json")]
    torn = [str(path) for path in pages if marks.search((root / path).read_text("utf-8"))]
    assert torn == []
