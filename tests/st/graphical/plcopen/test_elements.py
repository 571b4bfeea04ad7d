"""Elements of diagrams: numbers, places, connections."""

import pytest

from achse.st.graphical.plcopen.elements import DiagramElements, connections_of
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.plcopen.documents import diagram, value, written


def test_elements_have_numbers_places_and_offsets() -> None:
    text = diagram("FBD", value(1, "ä < b", y=7), written(2, "q", "1.OUT", 1))
    elements = DiagramElements(text)
    assert list(elements.by_id) == ["1", "2"]
    assert elements.position(elements.by_id["1"]) == (10, 7)
    assert text[elements.at(elements.by_id["2"]) :].startswith("<outVariable")
    assert list(connections_of(elements.by_id["2"])) == [("1", "OUT"), ("1", "")]


@pytest.mark.parametrize("text", ["<FBD><a/>", "<FBD/>", '<x:FBD p="1"><a/></x:FBD>'])
def test_end_tag_may_be_missing(text: str) -> None:
    closed = DiagramElements(text.removesuffix("</x:FBD>"))
    assert closed.root.tag == "FBD"


def test_no_diagram_is_a_fault() -> None:
    with pytest.raises(Unexpected, match="no well-formed XML"):
        DiagramElements("<FBD><a></FBD")
