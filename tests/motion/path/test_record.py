"""Records of the path: what is there, and its size."""

from achse.motion.path.record import AXES, PIECE, STATE, piece_record, state_record


def test_a_fresh_state_is_at_rest_without_commands() -> None:
    state = state_record()
    assert (state.velocity, state.acceleration, state.hold, state.backwards) == (0.0, 0.0, 0, 0)
    assert (state.override, state.barrier) == (1.0, -1)


def test_pieces_have_eight_axes() -> None:
    piece = piece_record()
    assert len(piece.begin) == len(piece.end) == len(piece.slope) == AXES == 8
    assert PIECE.words * 8 < 3600
    assert "point" in STATE.fields
