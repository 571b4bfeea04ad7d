"""Exports at random: whatever a file has, reading it ends with a result or a typed error."""

import contextlib

from hypothesis import given
from hypothesis import strategies as st

from achse.st.files.exports import parse_export, tasks_of_export
from achse.st.files.plcopen.documents import parse_plcopen, tasks_of_plcopen
from achse.st.graphical.body import GraphicalBody
from achse.st.graphical.lowering import picture
from achse.st.graphical.pictures import no_value
from achse.st.lexis.source import SourceError
from achse.st.syntax.cursor import Unexpected
from tests.st.graphical.exports.test_charts import CHART
from tests.st.graphical.exports.test_function_charts import box, source, value, written
from tests.st.graphical.exports.test_networks import contact as exported_contact
from tests.st.graphical.exports.test_networks import rung
from tests.st.graphical.plcopen import documents

_DIAGRAM = documents.diagram(
    "LD", documents.rail(), documents.contact(1, "a", 0, edge="rising"),
    documents.block(2, "TON", documents.pin("IN", 1), outputs="Q", instanceName="t"),
    documents.coil(3, "q", "2.Q", storage="set"), documents.element("label", 4, label="l"),
)  # fmt: skip
_BODIES = (
    "_LD_BODY\n_NETWORKS : 1\n" + rung(exported_contact("a"), "q"),
    "_CFC_BODY\n" + value(1, "a") + box(2, "ADD", "", source(1)) + written(3, "q", source(2)),
    CHART,
    "LD a\nJMPC on\non:\nST q\n",
)


def _read(bodies: list[GraphicalBody]) -> None:
    for body in bodies:
        with contextlib.suppress(Unexpected):
            picture(body, no_value)
        _ = body.implicit_variables, body.readable_statements


@st.composite
def shuffled(draw: st.DrawFn, text: str) -> str:
    """A text whose lines are left out, repeated or exchanged."""
    lines = text.splitlines(keepends=True)
    for _ in range(draw(st.integers(0, 4))):
        first, second = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        change = draw(st.sampled_from(["drop", "copy", "swap", "cut"]))
        if change == "drop" and len(lines) > 1:
            del lines[first]
        elif change == "copy":
            lines.insert(first, lines[second])
        elif change == "cut":
            lines[first] = lines[first][: draw(st.integers(0, 20))] + "\n"
        else:
            lines[first], lines[second] = lines[second], lines[first]
    return "".join(lines)


@given(st.data())
def test_export_never_fails(data: st.DataObject) -> None:
    body = data.draw(st.sampled_from(_BODIES))
    text = (
        "PROGRAM MAIN\nVAR a, q : BOOL; END_VAR\n(* @END_DECLARATION := '0' *)\n"
        + body + "END_PROGRAM\nACTION A:\nLD a\nEND_ACTION\n"
        "RESOURCE\nTASK T (INTERVAL := T#1s);\nMAIN();\nEND_TASK\nEND_RESOURCE\n"
    )  # fmt: skip
    text = data.draw(shuffled(text))
    parsed = parse_export(text, "a.exp", "a")
    _read([one for one in parsed.source.drawings if isinstance(one, GraphicalBody)])
    tasks_of_export(text)


@given(st.data())
def test_document_fails_with_a_typed_error(data: st.DataObject) -> None:
    language = data.draw(st.sampled_from(["LD", "SFC"]))
    body = _DIAGRAM.replace("LD>", f"{language}>")
    whole = documents.document(documents.pou("MAIN", documents.variables(a="BOOL"), body))
    text = data.draw(shuffled(whole.replace("><", ">\n<"))).encode()
    try:
        parsed = parse_plcopen(text, "a.xml", "a")
        tasks_of_plcopen(text, "a.xml")
    except SourceError:
        return
    _read([one for one in parsed.source.drawings if isinstance(one, GraphicalBody)])
