"""Messages: JSON that pages read, and errors with code and name."""

import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError, RequestTimeout
from achse.web.messages import CallError, dumped, error_of, request_of

_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@given(_JSON)
def test_every_value_is_json_that_a_browser_reads(value: Any) -> None:
    def never(name: str) -> None:
        raise AssertionError(name)

    json.loads(dumped(value), parse_constant=never)


def test_numbers_that_json_does_not_have_are_null() -> None:
    assert dumped([1.5, math.nan, {"a": -math.inf}, (math.inf,)]) == '[1.5,null,{"a":null},[null]]'


@given(
    number=st.one_of(_JSON),
    name=st.one_of(st.just("hello"), _JSON),
    fields=st.one_of(st.dictionaries(st.text(), _JSON), _JSON),
    head=st.sampled_from(["", "[", "{", "\0"]),
)
def test_a_call_is_read_or_refused(number: Any, name: Any, fields: Any, head: str) -> None:
    text = head + json.dumps({"id": number, "call": name, "with": fields})
    try:
        request = request_of(text)
    except CallError as refusal:
        assert "expected" in str(refusal)  # noqa: PT017
    else:
        assert not head
        assert request == (number, name, fields)


@pytest.mark.parametrize("text", ["", "7", "[]", "[" * 100_000, '{"id": true, "call": "x"}'])
def test_what_is_not_a_call(text: str) -> None:
    with pytest.raises(CallError):
        request_of(text)


def test_errors_have_code_name_and_text() -> None:
    assert error_of(DeviceError(0x710, "symbol MAIN.x"))["name"] == "SYMBOL_NOT_FOUND"
    assert error_of(DeviceError(0x4655))["code"] == 0x4655
    assert error_of(RequestTimeout("no answer"))["name"] == "CLIENT_TIMEOUT"
    plain = error_of(CallError("to: expected a number"))
    assert plain == {"text": "to: expected a number", "code": None, "name": None, "link": None}
    assert error_of(ValueError())["text"] == "ValueError"


def test_an_error_has_a_link_where_a_site_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    assert error_of(DeviceError(0x4655))["link"] is None
    monkeypatch.setenv("ACHSE_DOCS", "http://127.0.0.1:8000/")
    link = "http://127.0.0.1:8000/reference/0x4655/"
    assert error_of(DeviceError(0x4655))["link"] == link
    assert error_of(CallError("to: expected a number"))["link"] is None
    monkeypatch.setenv("ACHSE_DOCS", "javascript:alert(1)//")
    assert error_of(DeviceError(0x4655))["link"] is None
