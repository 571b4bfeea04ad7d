"""Records of the path: what is there, and its size."""

from achse.motion.path.record import AXES, ELEMENT, STATE, element_record, state_record


def test_a_fresh_state_is_at_rest_without_commands() -> None:
    state = state_record()
    assert (state.velocity, state.acceleration, state.hold, state.backwards) == (0.0, 0.0, 0, 0)
    assert (state.override, state.barrier) == (1.0, -1)


def test_elements_have_eight_axes() -> None:
    element = element_record()
    assert len(element.begin) == len(element.end) == len(element.slope) == AXES == 8
    assert ELEMENT.words * 8 < 3600
    assert "point" in STATE.fields
