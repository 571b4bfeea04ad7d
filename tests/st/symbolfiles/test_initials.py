# ruff: noqa: N801, N815 -- IEC names carry their prefix
"""Initial values in symbol files: literals by path, both ways."""

from typing import Any

import pytest

from achse.iec import ARRAY, BOOL, INT, STRING, TIME, IecType, Struct, iec_type, var
from achse.st.lexis.xml import parse_xml
from achse.st.symbolfiles.initials import initial_image, initial_parts


class ST_Part(Struct):
    nValue = var(INT, 3)
    bOn = var(BOOL)
    aTimes = var(ARRAY(TIME, (1, 2)))
    sText = var(STRING(8))


PART = iec_type(ST_Part)


def _image(type: IecType[Any], xml: str) -> bytes | None:
    return initial_image(type, parse_xml(f"<Default>{xml}</Default>".encode(), "f"))


def test_parts_that_differ_are_named() -> None:
    data = PART.encode({"nValue": 3, "bOn": True, "aTimes": [0, 1500], "sText": "a'b"})
    assert initial_parts(PART, data) == [
        (".bOn", "Bool", "true"),
        (".aTimes[2]", "DateTime", "T#1s500ms"),
        (".sText", "String", "a$'b"),
    ]


def test_a_scalar_is_always_said() -> None:
    assert initial_parts(INT, bytes(2)) == [("", "Value", "0")]


@pytest.mark.parametrize(
    ("xml", "value"),
    [
        ("<Value>16#7F</Value>", 127),
        ("<Value> -5 </Value>", -5),
    ],
)
def test_a_literal_becomes_bytes(xml: str, value: int) -> None:
    assert _image(INT, xml) == INT.encode(value)


def test_parts_are_put_into_the_start_value() -> None:
    xml = "<SubItem><Name>.sText</Name><String>xy</String></SubItem>"
    assert _image(PART, xml) == PART.encode({"sText": "xy"})


@pytest.mark.parametrize(
    "xml",
    [
        "",
        "<Value>GVL.MOST + 1</Value>",
        "<Value>70000</Value>",
        "<SubItem><Name>.none</Name><Value>1</Value></SubItem>",
        "<SubItem><Name>[1</Name><Value>1</Value></SubItem>",
        "<Other>1</Other>",
    ],
)
def test_what_is_no_literal_leaves_the_start_value(xml: str) -> None:
    assert _image(INT, xml) is None
