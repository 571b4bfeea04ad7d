"""XML of sources and symbol files: places of faults, nothing that grows."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import Element, escape, parse_xml


def test_a_tree_with_text_attributes_and_lines() -> None:
    root = parse_xml(b'<a x="1">\n <b>one</b>\n <b>two &amp; <![CDATA[<3]]></b>\n</a>', "f.tmc")
    assert (root.tag, root.attributes, root.location) == ("a", {"x": "1"}, ("f.tmc", 1, 1))
    assert [(item.text, item.location[1:]) for item in root.all("b")] == [
        ("one", (2, 2)),
        ("two & <3", (3, 2)),
    ]
    assert root.text_of("b") == "one"
    assert root.text_of("c", "none") == "none"
    assert root.find("c") is None


def test_blanks_around_a_cdata_part_are_kept() -> None:
    (item,) = parse_xml(b"<a><b>\n   <![CDATA[ x\ny]]>\n</b></a>", "f").children
    assert item.text == "\n    x\ny\n"
    assert item.text[item.begin :] == " x\ny\n"
    assert item.begin_at == ("f", 2, 13)


def test_a_tree_is_walked_in_order_of_the_file() -> None:
    root = parse_xml(b"<a><b><c/></b><d/></a>", "f")
    assert [element.tag for element in root.walk()] == ["a", "b", "c", "d"]


@pytest.mark.parametrize(
    "bomb",
    [
        b'<!DOCTYPE a [<!ENTITY x "xxxxxxxx"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>',
        b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>',
        b'<?xml version="1.0"?>\n<!DOCTYPE a><a/>',
    ],
)
def test_a_doctype_is_refused(bomb: bytes) -> None:
    with pytest.raises(SourceError, match="DOCTYPE is not accepted"):
        parse_xml(bomb, "f.tmc")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"<a>",
        b"<a></b>",
        b"<a/><a/>",
        b"no xml",
        b"<a>&nope;</a>",
        b"\xff\xfe\x00",
        b'<?xml version="1.0" encoding="no-such"?><a/>',
        b"<a>\x00</a>",
    ],
)
def test_what_is_no_xml_is_a_located_error(data: bytes) -> None:
    with pytest.raises(SourceError, match=r"^f\.tmc:\d+:\d+: no well-formed XML"):
        parse_xml(data, "f.tmc")


def test_depth_is_limited() -> None:
    with pytest.raises(SourceError, match="nest deeper than 64"):
        parse_xml(b"<a>" * 65 + b"</a>" * 65, "f.tmc")


@pytest.mark.parametrize("text", ["", "x", "-1", "1.5", "9" * 20, "٣", str(1 << 63)])
def test_a_number_that_is_none_says_where(text: str) -> None:
    root = parse_xml(f"<a>\n<n>{text}</n></a>".encode(), "f.tmc")
    with pytest.raises(SourceError, match=r"^f\.tmc:2:1: <n>: expected a whole number"):
        root.number_of("n")


def test_numbers_with_and_without_default() -> None:
    root = parse_xml(b"<a><n> 12 </n></a>", "f.tmc")
    assert (root.number_of("n"), root.number_of("n", 3), root.number_of("m", 3)) == (12, 12, 3)
    with pytest.raises(SourceError, match="expected <m> in <a>"):
        root.number_of("m")


def test_any_text_can_be_escaped() -> None:
    text = "a<b>&\"'\r\n\t\x00\ud800ä€"
    root = parse_xml(f'<a t="{escape(text)}">{escape(text)}</a>'.encode(), "f.tmc")
    assert root.text == "a<b>&\"'\r\n\t??ä€"
    assert isinstance(root, Element)


PICTURE = b"<o><v n='x'>1</v><l><o t='BoxTreeBox'><v>&lt;ST&gt;</v></o></l></o>"


def test_skipped_elements_have_neither_text_nor_children() -> None:
    data = b"<POU><Implementation><NWL>a" + PICTURE + b"</NWL></Implementation><ST>b</ST></POU>"
    root = parse_xml(data, "f", skip={"NWL"})
    assert [element.tag for element in root.walk()] == ["POU", "Implementation", "NWL", "ST"]
    assert (root.child("Implementation").child("NWL").text, root.text_of("ST")) == ("", "b")


@given(
    st.integers(0, 3),
    st.integers(0, 3),
    st.sampled_from([b"<NWL/>", b"<NWL>x</NWL>", b"<x:NWL/>", b"<NWL><NWL/><v/></NWL>"]),
    st.sampled_from([b"", b"t", b"<ST>c</ST>", b"<!-- </NWL> -->", b"<![CDATA[</NWL>]]>"]),
    st.sampled_from([b"NWL", b"x:NWL"]),
    st.booleans(),
)
def test_skipping_changes_nothing_outside_of_the_skipped_element(
    before: int, inside: int, inner: bytes, text: bytes, tag: bytes, at_root: bool
) -> None:
    picture = b"<" + tag + b">" + text + inner * inside + text + b"</" + tag + b">"
    data = picture if at_root else b"<a>" + b"<b>1</b>" * before + picture + b"<c>2</c></a>"
    whole, part = parse_xml(data, "f"), parse_xml(data, "f", skip={"NWL"})
    assert part.tag == whole.tag
    if at_root:
        return
    assert [(item.tag, item.location, item.text) for item in part if item.tag != "NWL"] == [
        (item.tag, item.location, item.text) for item in whole if item.tag != "NWL"
    ]


@pytest.mark.parametrize(
    "data", [b"<a><NWL></a>", b"<a><NWL><b></NWL></a>", b"<a><NWL>&x;</NWL></a>"]
)
def test_a_skipped_element_has_to_be_well_formed(data: bytes) -> None:
    with pytest.raises(SourceError, match="no well-formed XML"):
        parse_xml(data, "f", skip={"NWL"})
