"""Bodies that are drawn: their text, their places in file and drawing."""

from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from tests.st.graphical.drawings import assign, contact, network, networks, read, unit


def test_offsets_behind_the_text_are_places_in_the_drawing_and_lines_of_the_file() -> None:
    body = GraphicalBody("NWL", b"<NWL>\n<o>\n  <o>", 20, 7)
    source = Source("PROGRAM MAIN", "MAIN.TcPOU", drawings=[body])
    at = body.name_place(8, "network 1, rung 2")
    assert source.locate(at) == ("MAIN.TcPOU", 8, 3)
    assert source.place(at) == source.place(at + 3) == "network 1, rung 2"
    assert source.place(20) == ""
    assert source.place(3) == ""
    fault = source.fault(at, "no", Code.UNSUPPORTED_DRAWING)
    assert (str(fault), fault.text) == ("MAIN.TcPOU:8:3: network 1, rung 2: no", "")


def test_text_and_settings_are_kept_and_decide_the_digest() -> None:
    texts = [(b"<NWL>a", b""), (b"<NWL>b", b""), (b"<NWL>a", b"x")]
    bodies = [GraphicalBody("NWL", text, 5, 1, settings) for text, settings in texts]
    assert [(body.text, body.settings) for body in bodies] == [
        (text.decode(), settings.decode()) for text, settings in texts
    ]
    sources = [Source("", "f", drawings=[body]) for body in bodies]
    assert len({source.digest for source in sources}) == 3


def test_each_body_knows_its_unit_and_part() -> None:
    inner = networks(network(assign(contact("a"), "a")))
    action = f'<Action Name="act"><Implementation>{inner}</Implementation></Action>'
    (program,) = read(unit("PROGRAM MAIN VAR a : BOOL; END_VAR", inner, action)).units
    for body, part in ((program.body, ""), (program.parts[0].body, "act")):  # type: ignore[union-attr]
        assert isinstance(body, GraphicalBody)
        assert (body.owner.unit, body.owner.part, body.owner.keeps_memory) == ("MAIN", part, True)
        assert list(body.owner.actions.values()) == ["act"]
        assert len(body.readable_statements) == 1


def test_a_body_that_cannot_be_read_has_no_readable_statements() -> None:
    assert GraphicalBody("NWL", b"<NWL>", 5, 1).readable_statements == ()
