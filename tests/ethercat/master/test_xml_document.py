"""XML that is bounded: no DOCTYPE wherever it is, no depth, no size that hurts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.xml_document import XmlRefusal, flag, number, number_of, parse_xml

GROWING = "".join(f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10))
BOMB = f"<!DOCTYPE a [<!ENTITY a0 'x'>{GROWING}]><a>&a9;</a>"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "not XML"),
        (b"\xff\xfe\x00", "not XML"),
        ("<a><b></a>", "not XML"),
        (BOMB, "DOCTYPE"),
        (BOMB.encode("utf-16"), "DOCTYPE"),
        ("<!--" + "x" * 9000 + "-->" + BOMB, "DOCTYPE"),
        (b"<?xml version='1.0' encoding='klingon'?><a/>", "not XML"),
        ("<a>" * 65 + "</a>" * 65, "64 deep"),
        ("<a>&unknown;</a>", "not XML"),
    ],
)
def test_what_is_refused(text: str | bytes, told: str) -> None:
    with pytest.raises(XmlRefusal, match=told):
        parse_xml(text)


def test_a_file_beyond_the_limit_is_not_looked_at() -> None:
    with pytest.raises(XmlRefusal, match="bytes"):
        parse_xml(bytes((64 << 20) + 1))


@pytest.mark.parametrize(
    ("text", "value"), [("10", 10), ("#x1A", 26), ("0x1a", 26), (" -3 ", -3), ("", 5)]
)
def test_numbers(text: str, value: int) -> None:
    assert number(parse_xml(f"<a><b>{text}</b></a>"), "b", 5) == value


@given(value=st.integers(0, 1 << 40), form=st.sampled_from(["{}", "#x{:X}", "0x{:x}", "#X{:04x}"]))
def test_each_form_of_a_number(value: int, form: str) -> None:
    assert number_of(form.format(value), "it") == value


def test_flags_and_what_is_no_number() -> None:
    root = parse_xml('<a one="1" true=" True " none="0"/>')
    assert [flag(root, name) for name in ("one", "true", "none", "other")] == [1, 1, 0, 0]
    assert not flag(None, "one")
    with pytest.raises(ValueError, match="it: expected a number, got '#x'"):
        number_of("#x", "it")
