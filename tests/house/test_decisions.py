"""Each decision record is in the index once, under its own title and number."""

import re
from pathlib import Path


def test_the_index_lists_each_record_by_its_title(root: Path) -> None:
    folder = root / "docs" / "decisions"
    listed = re.findall(r"^- \[([^\]]+)\]\(([^)]+)\)$", (folder / "index.md").read_text(), re.M)
    titles = {
        path.name: path.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        for path in folder.glob("0*.md")
    }
    assert {file: title for title, file in listed} == titles
    assert len(listed) == len(titles)


def test_titles_begin_with_their_number(root: Path) -> None:
    for path in (root / "docs" / "decisions").glob("0*.md"):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert re.fullmatch(rf"# {path.name[:4]} [A-Z`\[].*[^.]", first), first
