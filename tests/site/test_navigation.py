"""The order of the site's pages, and the list of them for programs."""

from pathlib import Path

from achse.site.navigation import how_to_groups, navigation, overview

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"


def test_every_how_to_page_is_in_one_group() -> None:
    grouped = [page for pages in how_to_groups(README).values() for page in pages]
    assert len(grouped) == len(set(grouped))
    there = {f"how-to/{path.name}" for path in HOW_TO.glob("*.md")}
    assert there - set(grouped) == {"how-to/release.md"}  # of the project, not of its users


def test_how_to_comes_before_decisions_and_no_page_is_lost() -> None:
    places = [
        "index.md", "tutorial.md", "how-to/install.md", "how-to/of-no-group.md", "changelog.md",
        "decisions/0001-a.md", "explanation/words.md", "support.md", "reference/index.md",
        "examples/README.md", "coverage/nc.md",
    ]  # fmt: skip
    sections = navigation("- Begin: [install](docs/how-to/install.md)\n", places)
    headings = [heading for section in sections for heading in section]
    assert headings.index("How to") < headings.index("Concepts") < headings.index("Project")
    assert sorted(_pages(sections)) == sorted(places)


def _pages(content: object) -> list[str]:
    if isinstance(content, str):
        return [content]
    below = content.values() if isinstance(content, dict) else content
    assert not isinstance(below, str)
    return [page for each in below for page in _pages(each)]  # type: ignore[attr-defined]


def test_the_list_for_programs_has_title_place_and_first_sentence() -> None:
    text = "# Move\n\nYou need: `pip install achse`.\n\nThe **axis** [moves](a.md). It stops.\n"
    listed = overview([{"How to": [{"Axes": ["how-to/move.md"]}]}], {"how-to/move.md": text})
    assert "\n## How to\n\n- [Move](how-to/move/): The axis moves.\n" in listed
