"""Whatever users see is listed; who changes the list tells it in the changelog."""

import subprocess
from pathlib import Path

import pytest

from tests.house.public_face import LISTED, public_face

CHANGELOG = "CHANGELOG.md"


def _git(root: Path, *arguments: str) -> str:
    run = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=True)
    return run.stdout


def _added(change: str) -> list[str]:
    """Lines that a change adds under the newest heading of the changelog."""
    return [line[1:] for line in change.splitlines() if line[:1] == "+" and line[:3] != "+++"]


def test_what_users_see_is_listed() -> None:
    listed = LISTED.read_text(encoding="utf-8").splitlines()
    now = public_face()
    gone = [f"- {line}" for line in listed if line not in now]
    new = [f"+ {line}" for line in now if line not in listed]
    assert not gone + new, (
        "what users see is another than tests/data/public_face.txt says: write a line into "
        "CHANGELOG.md, then call `python -m tests.house.public_face`\n" + "\n".join(gone + new)
    )


def test_the_latest_change_of_the_list_has_its_line_in_the_changelog(root: Path) -> None:
    """The change that is not committed yet, or else the latest commit that changed the list."""
    name = str(LISTED.relative_to(root))
    if not (root / ".git").exists():
        pytest.skip("this is not a checkout")
    changed = _git(root, "diff", "--name-only", "HEAD", "--", name, CHANGELOG).split()
    if name in changed:
        change = _git(root, "diff", "-U0", "HEAD", "--", CHANGELOG)
    else:
        commit = _git(root, "log", "-1", "--format=%H", "--", name).strip()
        if not commit:
            pytest.skip("the list is not committed yet")
        change = _git(root, "show", "-U0", "--format=", commit, "--", CHANGELOG)
    assert _added(change), f"{name} changed, but {CHANGELOG} got no line in the same commit"


def test_the_changelog_begins_with_what_is_not_released_yet(root: Path) -> None:
    headings = [
        line
        for line in (root / CHANGELOG).read_text(encoding="utf-8").splitlines()
        if line.startswith("## ")
    ]
    assert headings[0].endswith("(unreleased)"), headings[0]
