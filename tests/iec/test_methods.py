"""Arguments of methods as bytes."""

import pytest

from achse.iec.elementary import BOOL, DINT, INT, LREAL
from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.methods import Method, Parameter
from achse.iec.strings import STRING

MOVE = Method(
    "Move",
    (
        Parameter("fTarget", LREAL),
        Parameter("nDone", DINT, is_output=True),
        Parameter("bFast", BOOL),
        Parameter("sText", STRING(3), is_output=True),
    ),
    INT,
)


def test_a_call_carries_the_inputs_without_gaps() -> None:
    data = MOVE.encode_inputs({"bfast": True, "FTARGET": 1.0})
    assert data == LREAL.encode(1.0) + b"\1"
    assert MOVE.decode_inputs(data) == (1.0, True)


def test_an_answer_carries_the_return_value_and_the_outputs() -> None:
    data = MOVE.encode_answer((-1, 7, "ok"))
    assert data == b"\xff\xff" + b"\7\0\0\0" + b"ok\0\0"
    assert MOVE.decode_answer(data) == (-1, 7, "ok")


def test_a_method_may_have_nothing() -> None:
    reset = Method("Reset")
    assert reset.encode_inputs({}) == reset.encode_answer(()) == b""
    assert reset.decode_inputs(b"") == reset.decode_answer(b"") == ()


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(IecValueError, match="Move takes the input bFast"):
        MOVE.encode_inputs({"fTarget": 1.0})
    with pytest.raises(IecValueError, match="Move takes fTarget, bFast, got 'x'"):
        MOVE.encode_inputs({"fTarget": 1.0, "bFast": False, "x": 1})
    with pytest.raises(IecValueError, match="Move takes 3 results"):
        MOVE.encode_answer((1,))
    with pytest.raises(IecDecodeError, match="Move has 9 bytes of arguments, got 8"):
        MOVE.decode_inputs(bytes(8))
    with pytest.raises(IecDecodeError, match="Move has 10 bytes of arguments, got 11"):
        MOVE.decode_answer(bytes(11))
