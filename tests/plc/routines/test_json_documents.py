"""JSON documents as trees of numbered values."""

import json
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.routines.json_documents import JsonDocuments, JsonKind

PLAIN: st.SearchStrategy[Any] = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64)
    | st.floats(allow_nan=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@settings(max_examples=17)
@given(PLAIN)
def test_a_document_there_and_back(plain: Any) -> None:
    documents = JsonDocuments()
    number = documents.start(0)
    assert documents.read(number, json.dumps(plain))
    assert json.loads(documents.text(documents.root(number), as_json=True)) == plain


def test_a_walk_ends() -> None:
    documents = JsonDocuments()
    number = documents.start(0)
    documents.read(number, '{"a": [1, 2], "b": [], "a": 3}')
    root = documents.root(number)
    names = []
    here = documents.first(root)
    while here != documents.last(root):
        value = documents.value(here)
        assert value is not None
        names.append(value.name)
        here = documents.following(here)
    assert names == ["a", "b", "a"]
    empty = documents.find(root, "b")
    assert documents.first(empty) == documents.last(empty) != 0
    assert documents.find(root, "c") == documents.find(here, "c") == 0


def test_what_is_gone_is_none() -> None:
    documents = JsonDocuments()
    number = documents.start(0)
    documents.read(number, '{"a": [1, [2, 3]]}')
    array = documents.find(documents.root(number), "a")
    inner = documents.items(array)[1].number
    assert documents.remove(inner)
    assert not documents.remove(inner)
    assert (documents.first(inner), documents.text(inner, as_json=True)) == (0, "")
    assert documents.put(inner, 1, "", JsonKind.NULL, None) == 0
    assert not documents.read(number, "{")
    assert documents.text(array, as_json=True) == ""
    documents.end(number)
    assert documents.root(number) == 0


def test_hostile_texts() -> None:
    documents = JsonDocuments()
    number = documents.start(0)
    for text in ("[" * 100_000, '{"a":' * 5000, "", "nul", "1 2"):
        assert not documents.read(number, text)
    root = documents.root(number)
    assert documents.put_text(root, 0, "x", "[") == 0
    assert documents.put_text(root, 0, "x", '{"y": [true]}')
    assert documents.text(root, as_json=True) == '{"x":{"y":[true]}}'
