"""A fault says what it is, and refuses what its kind does not take."""

import re
from typing import Any

import pytest

from achse.faults.fault import ActiveFault, FaultError, FaultState
from achse.faults.frames import Drop
from achse.faults.kinds import STATION_FAULTS
from achse.station import Station


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"kind": "melt"}, "kind: expected one of drop, delay"),
        ({}, "kind: expected one of"),
        ({"kind": "drop", "colour": 1}, "colour: a fault has kind, at"),
        ({"kind": "drop", "code": 5}, "code: drop takes lasting, count, every, side, client"),
        ({"kind": "delay"}, "by: a fault of kind delay needs it"),
        ({"kind": "error"}, "code: a fault of kind error needs it"),
        ({"kind": "drop", "count": 0}, "count: expected 1 or more, got 0"),
        ({"kind": "drop", "count": True}, "count: expected int, got True"),
        ({"kind": "drop", "port": "851"}, "port: expected int, got '851'"),
        ({"kind": "drop", "port": 70000}, "port: expected 0..65535"),
        ({"kind": "drop", "side": "left"}, "side: expected request or answer"),
        ({"kind": "drop", "command": "dance"}, "command: expected one of read_device_info"),
        ({"kind": "drop", "offset": 1}, "offset: needs a group"),
        ({"kind": "drop_link", "lasting": 1.0}, "lasting: drop_link takes client"),
        ({"kind": "restart", "port": 851}, "port: restart takes nothing"),
    ],
)
def test_what_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(FaultError) as refusal:
        STATION_FAULTS.of(fields)
    assert str(refusal.value).startswith(message)


def test_fields_are_what_was_given() -> None:
    fields = {"kind": "error", "symbol": "MAIN.x", "code": 0x706, "at": 2.0, "count": 3}
    fault = STATION_FAULTS.of(fields)
    assert fault.fields() == fields
    assert str(fault) == "error at=2.0 count=3 symbol=MAIN.x code=0x706 (INVALID_DATA)"


@pytest.mark.parametrize(
    ("texts", "fields"),
    [
        (["code=0x706", "symbol=MAIN.x", "at=2"], {"code": 0x706, "symbol": "MAIN.x", "at": 2.0}),
        (["code=7", "lasting=50ms"], {"code": 7, "lasting": 0.05}),
        (["code=7", "at=1.5s"], {"code": 7, "at": 1.5}),
    ],
)
def test_texts_of_the_command_line(texts: list[str], fields: dict[str, Any]) -> None:
    assert STATION_FAULTS.parse("error", texts).fields() == {"kind": "error", **fields}


@pytest.mark.parametrize("text", ["code", "colour=1", "code=red", "at=soon", "at=ms"])
def test_texts_that_say_nothing_are_refused(text: str) -> None:
    with pytest.raises(FaultError):
        STATION_FAULTS.parse("error", [text])


def test_every_nth_and_a_count() -> None:
    active = ActiveFault(1, Drop(every=3, count=2), 0)
    assert not active.take()  # it has not begun
    active.state = FaultState.ACTIVE
    assert [active.take() for _ in range(6)] == [False, False, True] * 2
    assert active.used_up


@pytest.mark.parametrize("value", [float("inf"), float("nan"), 1e300, -1.0])
@pytest.mark.parametrize("field", ["at", "lasting", "by"])
def test_times_are_finite(field: str, value: float) -> None:
    with pytest.raises(FaultError, match=f"{field}: expected 0..1000000000"):
        STATION_FAULTS.of({"kind": "delay", "by": 1.0, field: value})


@pytest.mark.parametrize(
    ("text", "seconds"), [("1s", 1.0), ("50ms", 0.05), ("250us", 0.00025), ("2", 2.0)]
)
def test_a_moment_has_a_unit_as_in_toml(text: str, seconds: float) -> None:
    fault = STATION_FAULTS.of({"kind": "delay", "at": text, "lasting": text, "by": text})
    assert fault.fields() == {"kind": "delay", "at": seconds, "lasting": seconds, "by": seconds}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("soon", "lasting: expected seconds, or a text such as '2s', got 'soon'"),
        ("-1s", "lasting: expected 0..1000000000, got -1.0"),
        ("nan", "lasting: expected 0..1000000000, got nan"),
    ],
)
def test_a_moment_that_cannot_be_is_refused(text: str, message: str) -> None:
    with pytest.raises(FaultError, match=re.escape(message)):
        STATION_FAULTS.of({"kind": "drop", "lasting": text})


def test_moments_have_units_in_python_as_in_toml() -> None:
    fault = Station.demo().faults.add("drop", lasting="1s", at="20ms").fault
    assert str(fault) == "drop at=0.02 lasting=1.0"
