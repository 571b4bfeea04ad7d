"""Code sections of source files: found, changed, and nothing else touched."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.files.sections import (
    CodeSection,
    SectionError,
    edited,
    replace_source,
    sections_of,
)

POU = """\ufeff<?xml version="1.0" encoding="utf-8"?>\r
<TcPlcObject Version="1.1.0.1">\r
  <POU Name="FB_Press" Id="{1}" SpecialFunc="None">\r
    <Declaration><![CDATA[FUNCTION_BLOCK FB_Press\r
VAR\r
END_VAR]]></Declaration>\r
    <Implementation><ST><![CDATA[a := 1;]]></ST></Implementation>\r
    <Method Name="Close"><Declaration><![CDATA[METHOD Close]]></Declaration>\r
      <Implementation><ST><![CDATA[]]></ST></Implementation></Method>\r
    <Property Name="Width"><Declaration><![CDATA[PROPERTY Width : INT]]></Declaration>\r
      <Get Name="Get"><Implementation><ST><![CDATA[Width := 2;]]></ST></Implementation></Get>\r
    </Property>\r
    <Other><![CDATA[of somebody else]]></Other>\r
  </POU>\r
</TcPlcObject>\r
"""

CODE = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff")
    | st.sampled_from("\n\t"),
    max_size=40,
).filter(lambda text: "]]>" not in text)


def test_sections_of_an_xml_file_have_names_kinds_and_places() -> None:
    sections = sections_of(POU.encode(), is_xml=True)
    assert [(each.name, each.kind) for each in sections] == [
        ("FB_Press", "declaration"),
        ("FB_Press", "implementation"),
        ("FB_Press.Close", "declaration"),
        ("FB_Press.Close", "implementation"),
        ("FB_Press.Width", "declaration"),
        ("FB_Press.Width.Get", "implementation"),
    ]
    assert sections[0].text == "FUNCTION_BLOCK FB_Press\nVAR\nEND_VAR"
    lines = POU.removeprefix("\ufeff").split("\r\n")
    for each in sections:
        assert lines[each.line - 1][each.column - 1 :].startswith(each.text.partition("\n")[0])


@given(st.lists(CODE, min_size=6, max_size=6))
def test_other_code_leaves_the_rest_of_an_xml_file(texts: list[str]) -> None:
    content = POU.encode()
    before, changed = (
        sections_of(content, is_xml=True),
        edited(content, texts, is_xml=True),
    )
    after = sections_of(changed, is_xml=True)
    assert [each.text for each in after] == texts
    assert _around(changed, after) == _around(content, before)
    assert edited(changed, [each.text for each in before], is_xml=True) == content


def _around(content: bytes, sections: tuple[CodeSection, ...]) -> list[bytes]:
    ends = [0, *(each.end for each in sections)]
    starts = [*(each.start for each in sections), len(content)]
    return [content[end:start] for end, start in zip(ends, starts, strict=True)]


@pytest.mark.parametrize(
    ("content", "text", "expected"),
    [
        (b"a\r\nb", "c\nd", b"c\r\nd"),
        (b"\xef\xbb\xbfa\n", "b\n", b"\xef\xbb\xbfb\n"),
        (b"\xff\xfea\x00\r\x00\n\x00", "\u20ac\nb", b"\xff\xfe\xac\x20\r\x00\n\x00b\x00"),
        (b"\xfe\xff\x00a", "b\n", b"\xfe\xff\x00b\x00\n"),
        ("grün".encode("cp1252"), "größer", "größer".encode("cp1252")),
        (b"a\rb", "a\nb", b"a\rb"),  # the same text: the same bytes
    ],
)
def test_a_text_file_keeps_its_encoding_and_line_ends(
    content: bytes, text: str, expected: bytes
) -> None:
    assert edited(content, [text], is_xml=False) == expected


@pytest.mark.parametrize(
    ("content", "is_xml", "texts", "message"),
    [
        (POU.encode(), True, ["a"], "expected 6 sections, got 1"),
        (POU.encode(), True, ["]]>", *"bcdef"], "ends it in an XML file"),
        (POU.encode(), True, ["\x00", *"bcdef"], r"U\+0000"),
        ("grün".encode("cp1252"), False, ["π"], "cp1252, which has no 'π'"),
        (POU.encode("utf-16"), True, [], "expected a file in UTF-8"),
        (b"<a><b></a>", True, [], "no well-formed XML"),
        (b'<!DOCTYPE a [<!ENTITY b "c">]><a/>', True, [], "a DOCTYPE is not accepted"),
    ],
)
def test_what_a_file_cannot_hold_is_refused(
    content: bytes, is_xml: bool, texts: list[str], message: str
) -> None:
    with pytest.raises(SectionError, match=message):
        edited(content, texts, is_xml=is_xml)


def test_a_file_is_replaced_whole_with_its_permissions(tmp_path: Path) -> None:
    file, link = tmp_path / "MAIN.st", tmp_path / "link.st"
    file.write_bytes(b"old")
    file.chmod(0o640)
    link.symlink_to(file)
    replace_source(link, b"new")
    assert (file.read_bytes(), file.stat().st_mode & 0o777) == (b"new", 0o640)
    assert link.is_symlink()
    with pytest.raises(OSError, match="directory"):
        replace_source(tmp_path / "gone" / "MAIN.st", b"new")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["MAIN.st", "link.st"]
