"""XML documents by their numbers, against the parser of the standard library."""

from typing import TypeAlias
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.routines.xml_documents import XmlDocuments

NAMES = st.sampled_from(["a", "b", "item", "x-1", "n:s"])
TEXTS = st.text(st.characters(min_codepoint=32, max_codepoint=0x2FF), max_size=8)

Tree: TypeAlias = tuple[str, dict[str, str], str, list["Tree"]]

TREES: st.SearchStrategy[Tree] = st.recursive(
    st.tuples(NAMES, st.dictionaries(NAMES, TEXTS, max_size=2), TEXTS, st.just([])),
    lambda inner: st.tuples(
        NAMES, st.dictionaries(NAMES, TEXTS, max_size=2), st.just(""), st.lists(inner, max_size=3)
    ),
    max_leaves=6,
)


def _xml(tree: Tree) -> str:
    name, attributes, text, children = tree
    element = ElementTree.Element(name, attributes)
    element.text = text
    whole = ElementTree.tostring(element, encoding="unicode", short_empty_elements=False)
    head, _, tail = whole.rpartition("</")
    return head + "".join(map(_xml, children)) + "</" + tail


def _tree(documents: XmlDocuments, number: int) -> Tree:
    item = documents.item(number)
    assert item is not None
    children, at = [], documents.first(number, False, "")
    while documents.kind(at) == 1:
        children.append(_tree(documents, at))
        at = documents.following(at, "")
    assert at == documents.last(number, False)
    attributes = {one.name: one.text for one in item.attributes or ()}
    return item.name, attributes, item.text, children


def _plain(tree: Tree) -> Tree:
    """A tree as the parser gives it: without texts of blanks alone."""
    name, attributes, text, children = tree
    return name, attributes, text if text.strip() else "", [_plain(child) for child in children]


@settings(max_examples=30, deadline=None)
@given(TREES)
def test_what_is_read_is_written_and_read_again(tree: Tree) -> None:
    documents = XmlDocuments()
    first, second = documents.start(0), documents.start(0)
    assert documents.read(first, _xml(tree))
    top = documents.first(documents.root(first), False, "")
    assert _tree(documents, top) == _plain(tree)
    text = documents.text(documents.root(first), as_xml=True)
    assert text.startswith('<?xml version="1.0"?>\n')
    assert documents.feed(second, text.encode()[:7], False)
    assert documents.feed(second, text.encode()[7:], True)
    again = documents.first(documents.root(second), False, "")
    assert _tree(documents, again) == _plain(tree)
    documents.end(first)
    assert (documents.item(top), documents.root(first)) == (None, 0)
    assert documents.item(again) is not None


@pytest.mark.parametrize(
    "text",
    [
        *("", "<a>", "<a/><b/>", "text", "<a b=1/>", "<a>" * 300 + "</a>" * 300),
        '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>',
    ],
)
def test_what_is_no_xml_leaves_an_empty_document(text: str) -> None:
    documents = XmlDocuments()
    document = documents.start(0)
    assert not documents.read(document, text)
    assert documents.text(documents.root(document), as_xml=True) == '<?xml version="1.0"?>\n'


def test_unknown_numbers_are_none() -> None:
    documents = XmlDocuments()
    assert documents.root(7) == documents.kind(7) == documents.first(7, True, "") == 0
    assert (
        documents.following(7, "") == documents.child(7, "", "", "") == documents.path(7, "") == 0
    )
    assert documents.set(7, "x", False) == documents.last(7, False) == 0
    assert documents.text(7, as_xml=True) == ""
    assert not documents.remove(7, 8)
    documents.end(7)
