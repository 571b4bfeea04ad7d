"""HTML of notebooks: well-formed, and text stays text."""

import base64
from xml.etree import ElementTree

from hypothesis import given
from hypothesis import strategies as st

from achse.plot import Picture, PictureError, PlotExtraMissing
from achse.plot.markup import drawn, facts, picture, table

TEXT = st.text(st.characters(min_codepoint=32, exclude_categories=["Cs", "Cc", "Cn"]))


@given(
    caption=TEXT, head=st.lists(TEXT), rows=st.lists(st.lists(TEXT | st.floats() | st.booleans()))
)
def test_text_stays_text(
    caption: str, head: list[str], rows: list[list[str | float | bool]]
) -> None:
    tree = ElementTree.fromstring(table(caption, head, rows))
    assert (tree.findtext("caption") or "") == caption
    assert [cell.text or "" for cell in tree.findall("tr")[0]] == head
    assert len(tree.findall("tr")) == 1 + len(rows)
    known = [(text, "<b>") for text in head]
    tree = ElementTree.fromstring(facts(caption, known))
    assert [row.findtext("th") or "" for row in tree.findall("tr")] == head
    assert {row.findtext("td") for row in tree.findall("tr")} <= {"<b>"}


def test_numbers_are_short_and_at_the_right() -> None:
    shown = table("", [], [[1 / 3, 5, True, None]])
    assert '<td style="text-align:right">0.333333333</td>' in shown
    assert "<td>True</td><td>None</td>" in shown


def test_a_picture_is_in_the_page() -> None:
    tree = ElementTree.fromstring(picture(b"abc", '"<').replace('">', '"/>'))
    assert tree.attrib == {
        "alt": '"<',
        "src": "data:image/png;base64," + base64.b64encode(b"abc").decode(),
    }


def test_what_cannot_be_drawn_is_left_out() -> None:
    def refused(fault: Exception) -> Picture:
        raise fault

    assert drawn(lambda: refused(PlotExtraMissing())) is None
    assert drawn(lambda: refused(PictureError("nothing"))) is None
