"""Values as JSON: what is written into a text is read back from it."""

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec.elementary import BOOL, INT, LREAL
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.routines.json_symbols import plain_value, put_plain
from tests.plc.routines.conftest import TYPES, value_bytes


@settings(max_examples=40, deadline=None)
@given(TYPES, st.data())
def test_values_are_read_as_they_were_written(type: IecType[Any], data: st.DataObject) -> None:
    value = value_bytes(type, data, finite=True)
    got = bytearray(type.size)
    put_plain(type, json.loads(json.dumps(plain_value(type, value))), got)
    assert plain_value(type, bytes(got)) == plain_value(type, value)


@pytest.mark.parametrize("value", [None, "text", 70000, 1.5, True, [1], {"a": 1}])
def test_what_does_not_fit_stays(value: Any) -> None:
    got = bytearray(INT.encode(-7))
    put_plain(INT, value, got)
    assert INT.decode(bytes(got)) == -7


def test_members_are_found_without_case_and_the_others_stay() -> None:
    type: StructType[Any] = StructType(
        "ST",
        [Variable(INT, name="n"), Variable(BOOL, name="on"), Variable(StringType(5), name="s")],
    )
    got = bytearray(type.size)
    put_plain(type, {"N": 5, "other": 1, "S": "abc"}, got)
    put_plain(type, {"ON": True}, got)
    assert plain_value(type, bytes(got)) == {"n": 5, "on": True, "s": "abc"}


def test_number_that_json_lacks_is_null() -> None:
    assert plain_value(LREAL, LREAL.encode(float("inf"))) is None
