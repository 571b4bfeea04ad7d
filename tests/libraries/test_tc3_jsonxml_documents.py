"""Tc3_JsonXml: XML documents that programs read and build, and files of documents."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

TYPES = {
    "Bool": ("BOOL", st.booleans()),
    "Double": ("LREAL", st.floats(-1e9, 1e9)),
    "Float": ("REAL", st.floats(-1e9, 1e9, width=32)),
    "Int": ("DINT", st.integers(-(2**31), 2**31 - 1)),
    "Lint": ("LINT", st.integers(-(2**63), 2**63 - 1)),
    "Uint": ("UDINT", st.integers(0, 2**32 - 1)),
    "Ulint": ("ULINT", st.integers(0, 2**64 - 1)),
}

VALUES = (
    "PROGRAM MAIN VAR x : FB_XmlDomParser; r, m, c : SXmlNode; a : SXmlAttribute;"
    " s : STRING(2000); n : UDINT;"
    + "".join(f" v{key}, w{key}, b{key}, d{key} : {type};" for key, (type, _) in TYPES.items())
    + " END_VAR x.NewDocument(); m := x.AppendNode(x.GetDocumentNode(), 'm');"
    + "".join(
        f" c := x.AppendChildAs{key}(m, 'c{key}', v{key}); b{key} := x.NodeAs{key}(c);"
        f" x.SetChildAs{key}(c, w{key}); a := x.AppendAttributeAs{key}(c, 'a', v{key});"
        f" d{key} := x.AttributeAs{key}(a); x.SetAttributeAs{key}(a, w{key});"
        for key in TYPES
    )
    + " n := x.CopyDocument(s, SIZEOF(s)); END_PROGRAM"
)


@pytest.fixture(scope="module")
def values() -> Ran:
    return Ran(VALUES)


@settings(max_examples=10, deadline=None)
@given(
    old=st.fixed_dictionaries({key: strategy for key, (_, strategy) in TYPES.items()}),
    new=st.fixed_dictionaries({key: strategy for key, (_, strategy) in TYPES.items()}),
)
def test_values_of_all_types(values: Ran, old: dict[str, Any], new: dict[str, Any]) -> None:
    main: Any = values.plc.instance("MAIN")
    for key in TYPES:
        main[f"v{key}"], main[f"w{key}"] = old[key], new[key]
    values.cycle()
    assert values.plc.failure == ""
    for key in TYPES:
        assert (main[f"b{key}"], main[f"d{key}"]) == (old[key], old[key])
    root = ElementTree.fromstring(values["s"])
    assert [child.tag for child in root] == [f"c{key}" for key in TYPES]
    for key, child in zip(TYPES, root, strict=True):
        assert child.get("a") == child.text
        assert child.text is not None
        if key == "Bool":
            assert child.text == ("true" if new[key] else "false")
        else:
            assert float(child.text) == pytest.approx(float(new[key]), rel=1e-7)


def test_document_is_searched_and_changed() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR x : FB_XmlDomParser; doc, m, one, two, k, copy : SXmlNode;"
        " it, last : SXmlIterator; a, b : SXmlAttribute; walks, names, marks, texts : STRING(99);"
        " s, part : STRING(999); n, size, none, empty : UDINT; t : ARRAY [1..20] OF BOOL; END_VAR"
        " empty := x.GetDocumentLength(); t[1] := x.GetRootNode() = 0;"
        ' doc := x.ParseDocument(\'<ms a="0"><m t="1" u="2">A</m><k/><m t="2">B</m></ms>\');'
        " m := x.ChildByName(doc, 'ms'); t[2] := m = x.GetRootNode() AND m = x.Child(doc);"
        " one := x.ChildByAttribute(m, 't', '1');"
        " two := x.ChildByAttributeAndName(m, 't', '2', 'm');"
        " t[3] := x.ChildByAttributeAndName(m, 't', '2', 'k') = 0;"
        " t[4] := x.FirstNodeByPath(doc, 'ms/m') = one AND x.FirstNodeByPath(doc, 'ms/q') = 0;"
        " k := x.NextSibling(one); t[5] := x.NextSiblingByName(one, 'm') = two;"
        " t[6] := x.NextSibling(two) = 0 AND x.ChildByName(m, 'q') = 0;"
        " k := x.Children(m, it); WHILE NOT x.IsEnd(it) DO walks := CONCAT(walks, x.NodeName(k));"
        " k := x.Children(m, it); END_WHILE k := x.ChildrenByName(m, it, 'm');"
        " WHILE NOT x.IsEnd(it) DO texts := CONCAT(texts, x.NodeText(x.Node(it)));"
        " x.ChildrenByName(m, it, 'm'); END_WHILE it := x.BeginByName(m, 'm');"
        " WHILE NOT x.Compare(it, x.End(m)) DO texts := CONCAT(texts, x.NodeText(x.Node(it)));"
        " it := x.NextByName(it, 'm'); END_WHILE it := x.Begin(m); it := x.Next(it);"
        " walks := CONCAT(walks, x.NodeName(x.Node(it))); it := x.AttributeBegin(one);"
        " WHILE NOT x.IsEnd(it) DO a := x.AttributeFromIterator(it);"
        " names := CONCAT(names, x.AttributeName(a)); it := x.Next(it); END_WHILE"
        " a := x.Attributes(one, it); WHILE NOT x.IsEnd(it) DO"
        " marks := CONCAT(marks, x.AttributeText(a)); a := x.Attributes(one, it); END_WHILE"
        " x.ClearIterator(it); t[7] := it = 0; a := x.Attribute(one, 't');"
        " t[8] := x.AttributeText(x.NextAttribute(a)) = '2' AND x.Attribute(one, 'q') = 0;"
        " b := x.InsertAttribute(one, a, 'first'); x.SetAttribute(b, '<&>');"
        " x.AppendAttributeCopy(two, b); x.InsertAttributeCopy(two, x.Attribute(two, 't'), b);"
        " copy := x.AppendCopy(m, one); x.SetChild(copy, 'C', FALSE);"
        " x.AppendChild(copy, 'cd', '<]]>', TRUE); x.InsertCopy(m, one, x.ChildByName(m, 'k'));"
        " x.AppendAttribute(x.InsertChild(m, two, 'new'), 'v', '\"w\"');"
        " t[9] := x.RemoveChild(m, x.NextSibling(one)) AND NOT x.RemoveChild(m, doc);"
        " t[10] := x.RemoveChildByName(m, 'k') AND NOT x.RemoveChildByName(m, 'q');"
        " t[11] := x.AppendNode(m, 'no name') = 0 AND x.AppendNode(12345, 'n') = 0;"
        " t[12] := x.GetNodeTextLength(one) = 1 AND x.GetAttributeTextLength(b) = 3;"
        " n := x.CopyNodeText(one, part, SIZEOF(part)); t[13] := n = 2 AND part = 'A';"
        " n := x.CopyAttributeText(b, part, SIZEOF(part)); t[14] := n = 4 AND part = '<&>';"
        " n := x.CopyNodeXml(two, part, SIZEOF(part)); t[15] := n = x.GetNodeXmlLength(two) + 1;"
        " none := x.CopyDocument(s, 10); size := x.CopyDocument(s, SIZEOF(s)); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert ran["t"][:15] == [True] * 15
    assert (ran["walks"], ran["texts"]) == ("mkmk", "ABAB")
    assert (ran["names"], ran["marks"]) == ("tu", "12")
    assert (ran["none"], ran["size"], ran["empty"]) == (0, len(ran["s"]) + 1, 22)
    assert ran["part"] == '<m first="&lt;&amp;&gt;" t="2" first="&lt;&amp;&gt;">B</m>\n'
    assert ran["s"] == (
        '<?xml version="1.0"?>\n<ms a="0">\n'
        '\t<m first="&lt;&amp;&gt;" t="1" u="2">A</m>\n\t<new v="&quot;w&quot;" />\n'
        '\t<m first="&lt;&amp;&gt;" t="2" first="&lt;&amp;&gt;">B</m>\n'
        '\t<m first="&lt;&amp;&gt;" t="1" u="2">C<cd><![CDATA[<]]]]><![CDATA[>]]></cd></m>\n</ms>\n'
    )


FILES = (
    "PROGRAM MAIN VAR x, y : FB_XmlDomParser; j, k : FB_JsonDomParser; step, count : INT;"
    " exec : BOOL; hr : HRESULT; done : BOOL; sizes : ARRAY [0..3] OF UDINT;"
    " results : ARRAY [1..6] OF HRESULT;"
    " i : DINT; n : SXmlNode; v : SJsonValue; END_VAR CASE step OF"
    " 0: n := x.AppendNode(x.GetDocumentNode(), 'top'); v := j.ParseDocument('[]');"
    " FOR i := 1 TO 300 DO x.AppendChildAsInt(n, 'item', i); j.PushbackIntValue(v, i); END_FOR"
    " exec := TRUE; step := 1;"
    " 1: done := x.SaveDocumentToFile(sFile := 'a.xml', bExec := exec, hrErrorCode => hr);"
    " 2: done := y.LoadDocumentFromFile(sFile := 'a.xml', bExec := exec, hrErrorCode => hr);"
    " 3: done := j.SaveDocumentToFile(sFile := 'a.json', bExec := exec, hrErrorCode => hr);"
    " 4: done := k.LoadDocumentFromFile(sFile := 'a.json', bExec := exec, hrErrorCode => hr);"
    " 5: done := y.LoadDocumentFromFile(sFile := 'a.json', bExec := exec, hrErrorCode => hr);"
    " 6: done := k.LoadDocumentFromFile(sFile := 'none', bExec := exec, hrErrorCode => hr);"
    " END_CASE IF step = 2 AND done THEN sizes[0] := x.GetDocumentLength();"
    " sizes[1] := y.GetDocumentLength(); END_IF IF step = 4 AND done THEN"
    " sizes[2] := j.GetDocumentLength(); sizes[3] := k.GetDocumentLength(); END_IF"
    " IF done THEN count := count + 1; END_IF"
    " IF step > 0 AND step < 7 AND NOT exec THEN results[step] := hr; step := step + 1;"
    " exec := TRUE; END_IF END_PROGRAM"
)


def test_documents_in_files(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(FILES, encoding="utf-8")
    document: dict[str, Any] = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
    (tmp_path / "shown").mkdir()
    here = Station(parse(document, "a.toml"), base=tmp_path)
    here.advance(0.6)
    plc = here.plcs[851]
    assert plc.failure == ""
    main: Any = plc.instance("MAIN")
    assert (main["step"], main["count"]) == (7, 4)
    sizes = list(main["sizes"])
    assert sizes[0] == sizes[1] > 4096
    assert sizes[2] == sizes[3]
    root = ElementTree.parse(tmp_path / "shown" / "a.xml").getroot()
    assert [int(item.text or "") for item in root] == list(range(1, 301))
    listed = json.loads((tmp_path / "shown" / "a.json").read_text(encoding="utf-8"))
    assert listed == list(range(1, 301))
    results = [int(value) & 0xFFFFFFFF for value in main["results"]]
    assert results[:4] == [0] * 4
    assert results[4] == 0x9811070F
    assert results[5] == 0x9811070C
