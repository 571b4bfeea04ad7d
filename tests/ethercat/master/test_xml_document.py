"""XML that is bounded: no DOCTYPE wherever it is, no depth, no size that hurts."""

from pathlib import Path
from xml.etree.ElementTree import Element

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.xml_document import (
    XmlRefusal,
    encoding_of,
    flag,
    number,
    number_of,
    parse_xml,
    read_bounded,
)

GROWING = "".join(f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10))
BOMB = f"<!DOCTYPE a [<!ENTITY a0 'x'>{GROWING}]><a>&a9;</a>"


@pytest.mark.parametrize(
    ("text", "message"),
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
def test_what_is_refused(text: str | bytes, message: str) -> None:
    with pytest.raises(XmlRefusal, match=message):
        parse_xml(text)


def test_a_file_beyond_the_limit_is_not_looked_at(tmp_path: Path) -> None:
    with pytest.raises(XmlRefusal, match="bytes"):
        parse_xml(bytes((64 << 20) + 1))
    file = tmp_path / "long.xml"
    with file.open("wb") as opened:
        opened.truncate(200 << 20)
    with pytest.raises(XmlRefusal, match="209715200 bytes, 67108864 are read"):
        read_bounded(file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<a " + " ".join(f'b{n}=""' for n in range(300_000)) + "/>", "a tag or comment"),
        ("<a><!--" + "x" * (3 << 20) + "--></a>", "a tag or comment"),
        ("<a>" + "".join(f"<b{n}/>" for n in range(21_000)) + "</a>", "more than 20000 names"),
    ],
)
def test_what_grows_is_refused(text: str, message: str) -> None:
    with pytest.raises(XmlRefusal, match=message):
        parse_xml(text)


@given(st.lists(st.lists(st.booleans(), max_size=5), max_size=5))
def test_dropped_elements_take_no_room(rows: list[list[bool]]) -> None:
    """The limit is of those that are kept; each is seen whole, at its place in the text."""
    text = "".join(f"<b>{'<c/>' * len(row)}<d> {any(row)} </d></b>\n" for row in rows)
    data = f"<a>{text}</a>".encode()
    seen: list[bytes] = []

    def handle(element: Element, place: slice) -> bool:
        seen.append(data[place] + b"</b>")
        assert len(element) == seen[-1].count(b"<c/>") + 1
        return element.findtext("d") == " True "

    with pytest.MonkeyPatch.context() as patch:
        stored = sum(len(row) + 2 for row in rows if any(row))
        largest = max((len(row) + 2 for row in rows), default=0)
        patch.setattr("achse.ethercat.master.xml_document._MOST_IN_TREE", stored + largest + 1)
        root = parse_xml(data, handlers={"a/b": handle})
    assert len(root) == sum(map(any, rows))
    assert b"\n".join(seen) == text.strip().encode()
    with pytest.raises(KeyError, match="of a handler"):
        parse_xml("<a><b/></a>", handlers={"a/b": _refuse})


def _refuse(element: Element, place: slice) -> bool:
    raise KeyError("of a handler")


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


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (b"<a/>", "utf-8"),
        (b"<?xml version='1.0'?><a/>", "utf-8"),
        (b"<?xml version='1.0' encoding='ISO-8859-1'?><a/>", "ISO-8859-1"),
        ("<a/>".encode("utf-16"), "UTF-16LE"),
        (b"\xfe\xff" + "<a/>".encode("utf-16-be"), "UTF-16BE"),
        (b"<?xml version='1.0' encoding='klingon'?><a/>", "klingon"),
    ],
)
def test_encodings(data: bytes, name: str) -> None:
    assert encoding_of(data) == name
