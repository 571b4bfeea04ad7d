"""Elements of a contour begin as lines with the programmed feed."""

from achse.gcode.canon import Origin
from achse.gcode.geometry.contour import ContourElement, MoveFacts


def test_an_element_is_a_line_until_it_has_a_normal() -> None:
    facts = MoveFacts(Origin("", 1, 0, 0, 1), (0.0,) * 5, 10.0, 5.0, False, False, False)
    element = ContourElement(facts, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert element.normal is None
    assert element.scale == 1.0
