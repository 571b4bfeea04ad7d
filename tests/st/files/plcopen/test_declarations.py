"""Interfaces in PLCopen XML: types, values and blocks as text."""

import pytest

from achse.st.files.plcopen.declarations import DeclarationText, type_text, value_text
from achse.st.lexis.xml import Element, parse_xml


def element(text: str) -> Element:
    return parse_xml(text.encode(), "a.xml")


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("<BOOL/>", "BOOL"),
        ("<derived name='FB_X'/>", "FB_X"),
        ("<string length='30'/>", "STRING(30)"),
        ("<wstring/>", "WSTRING"),
        (
            "<array><dimension lower='0' upper='2'/><dimension lower='1' upper='n'/>"
            "<baseType><INT/></baseType></array>",
            "ARRAY[0..2, 1..n] OF INT",
        ),
        ("<pointer><baseType><REAL/></baseType></pointer>", "POINTER TO REAL"),
        (
            "<subrangeSigned><range lower='-3' upper='4'/><baseType><INT/></baseType>"
            "</subrangeSigned>",
            "INT (-3..4)",
        ),
        (
            "<enum><values><value name='a'/><value name='b' value='7'/></values></enum>",
            "(a, b := 7)",
        ),
    ],
)
def test_types(inside: str, text: str) -> None:
    assert type_text(element(f"<type>{inside}</type>")) == text


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("<simpleValue value='T#1s'/>", "T#1s"),
        (
            "<arrayValue><value repetitionValue='3'><simpleValue value='0'/></value><value>"
            "<simpleValue value='5'/></value></arrayValue>",
            "[3(0), 5]",
        ),
        (
            "<structValue><value member='a'><simpleValue value='1'/></value></structValue>",
            "(a := 1)",
        ),
    ],
)
def test_values(inside: str, text: str) -> None:
    assert value_text(element(f"<initialValue>{inside}</initialValue>")) == text


def test_variables_are_on_the_lines_of_their_elements() -> None:
    pou = element(
        "<pou name='MAIN' pouType='program'>\n<interface>\n\n<localVars retain='true'>\n"
        "<variable name='a' address='%IX0.1'><type><BOOL/></type></variable>\n\n"
        "<variable name='b'><type><INT/></type><initialValue><simpleValue value='3'/>"
        "</initialValue></variable></localVars></interface></pou>"
    )
    text = DeclarationText(pou.location)
    text.unit(pou, pou.find("interface"))
    lines = text.element.text.split("\n")
    assert [line.strip() for line in lines] == [
        "PROGRAM MAIN", "", "", "VAR RETAIN", "a AT %IX0.1 : BOOL;", "", "b : INT := 3; END_VAR",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("address", "text"),
    [("%QD0.2", "%Q*"), ("%IX0.16", "%I*"), ("%MW3", "%MW3"), ("%IX0.7", "%IX0.7")],
)
def test_address_with_two_numbers_is_left_to_the_station(address: str, text: str) -> None:
    variable = f"<variable name='a' address='{address}'><type><DINT/></type></variable>"
    block = element(f"<localVars>{variable}</localVars>")
    text_of_block = DeclarationText(block.location)
    text_of_block.block(block)
    assert f"a AT {text} : DINT;" in text_of_block.element.text
