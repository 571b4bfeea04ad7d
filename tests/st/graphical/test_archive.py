"""Object archives: types, quotes, lists, dictionaries."""

import pytest

from achse.st.graphical.archive import ArchiveObject, read_archive
from achse.st.syntax.cursor import Unexpected

TEXT = """<XmlArchive>
  <Data>
    <o xml:space="preserve" t="Root">
      <v n="Name">"a &lt;b&gt; &amp; &#65;
"quoted" c:\\x"</v>
      <v n="Empty" />
      <n n="Nothing" />
      <v n="Id">26L</v>
      <v n="On">true</v>
      <v n="Comment">"left out"</v>
      <l2 n="List" cet="Item">
        <o><v n="Id">1</v></o>
        <o t="Other" />
        <n />
      </l2>
      <l2 n="Names" cet="String"><v>IN</v><v>PT</v></l2>
      <d2 n="Flags" ckt="String" cvt="Flag">
        <v>"Init"</v>
        <o><v n="Use">true</v></o>
      </d2>
    </o>
  </Data>
  <TypeList><Type n="Root">System</Type></TypeList>
</XmlArchive>"""


def test_members_have_their_types_and_values() -> None:
    root = read_archive(TEXT)
    assert root.type == "Root"
    assert root.text("Name") == 'a <b> & A\n"quoted" c:\\x'
    assert (root.text("Empty"), root.text("Nothing", "none"), root.number("Id")) == ("", "none", 26)
    assert (root.flag("On"), root.flag("Off"), root.number("Gone", 7)) == (True, False, 7)
    assert "Comment" not in root.members
    assert TEXT[root.at :].startswith('<o xml:space="preserve" t="Root">')


def test_elements_of_a_list_have_its_type_or_their_own() -> None:
    root = read_archive(TEXT)
    assert [item.type for item in root.objects("List")] == ["Item", "Other"]
    members = root.part("List")
    assert members is not None
    assert members.items[2] is None
    names = root.part("Names")
    assert names is not None
    assert names.items == ["IN", "PT"]


def test_a_dictionary_has_keys_and_values_in_turn() -> None:
    flags = read_archive(TEXT).part("Flags")
    assert flags is not None
    ((key, value),) = flags.pairs
    assert isinstance(value, ArchiveObject)
    assert (key, value.type, value.flag("Use")) == ("Init", "Flag", True)


def test_comments_and_cdata_are_read_as_the_document_has_them() -> None:
    text = '<Data><o t="A"><!-- <o t="B"/> --><v n="x"><![CDATA["1 < 2"]]></v></o></Data>'
    assert read_archive(text).text("x") == "1 < 2"


@pytest.mark.parametrize("text", ["", "<Data></Data>", "<Data><o /><o /></Data>", "</o>", "<o>"])
def test_what_is_no_archive_is_refused(text: str) -> None:
    with pytest.raises(Unexpected, match="expected an object archive"):
        read_archive(text)
