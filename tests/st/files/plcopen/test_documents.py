"""Documents in PLCopen XML: units, lists, types, vendor's parts and tasks."""

import pytest

from achse.st.files.plcopen.documents import is_plcopen, parse_plcopen, tasks_of_plcopen
from achse.st.syntax import units
from tests.st.graphical.drawings import Drawn
from tests.st.graphical.plcopen.documents import document, pou, program, text, variables

TASKS = """<configurations><configuration name="c"><resource name="r">
<task name="fast" interval="T#20ms" priority="1"><pouInstance name="i" typeName="MAIN"/>
<pouInstance name="j" typeName="MAIN"/></task>
<task name="slow" interval="PT0.5S" priority="4"><pouInstance name="App.MAIN" typeName=""/></task>
<task name="free"/>
<globalVars name="G L"><variable name="total"><type><INT/></type></variable></globalVars>
</resource></configuration></configurations>"""
PLAIN = (
    "<addData><data name='x/interfaceasplaintext'><InterfaceAsPlainText><xhtml>{}</xhtml>"
    "</InterfaceAsPlainText></data></addData>"
)


def test_units_types_and_lists_run_together() -> None:
    types = (
        "<dataType name='ST_X'><baseType><struct><variable name='n'><type><INT/></type></variable>"
        "</struct></baseType></dataType><dataType name='E'><baseType><enum><values>"
        "<value name='off'/><value name='on'/></values></enum></baseType></dataType>"
    )
    body = text("x.n := x.n + 2;\ntotal := x.n;\ne := on;")
    whole = document(pou("MAIN", variables(x=".ST_X", e=".E"), body), types=types, instances=TASKS)
    parsed = parse_plcopen(whole.encode(), "plc.xml", "plc")
    assert not parsed.faults
    assert [unit.name for unit in parsed.units] == ["ST_X", "E", "MAIN", "G_L"]
    Drawn(parsed).rows("", "x.n e", [" | 2 1", " | 4 1"])


def test_fault_is_on_the_line_of_the_file() -> None:
    whole = document(pou("MAIN", variables(n="INT"), text("n := 1;\nn := ;")))
    (fault,) = parse_plcopen(whole.encode(), "plc.xml", "plc").faults
    assert whole.split("\n")[fault.location.line - 1].startswith("n := ;")
    whole = whole.replace("<INT/>", "<array/>").replace("n := ;", "")
    (fault, *_) = parse_plcopen(whole.encode(), "plc.xml", "plc").faults
    assert 'name="n"' in whole.split("\n")[fault.location.line - 1]


def test_declaration_as_text_comes_first() -> None:
    declared = PLAIN.format("PROGRAM MAIN\nVAR a, b : INT := 3; END_VAR")
    whole = document(pou("MAIN", variables(a="BOOL"), text("b := a + 1;")))
    whole = whole.replace("</pou>", declared + "</pou>")
    Drawn(parse_plcopen(whole.encode(), "plc.xml", "plc")).rows("a", "b", ["4 | 5"])


def test_methods_properties_and_bases_of_vendors() -> None:
    base = pou("Base", variables(n="INT"), text(""), "functionBlock")
    method = (
        "<Method name='Add'><interface><returnType><INT/></returnType><inputVars>"
        "<variable name='d'><type><INT/></type></variable></inputVars></interface><body>"
        + text("n := n + d;\nAdd := n;") + "</body></Method>"
    )  # fmt: skip
    property = (
        "<Property name='Half'><interface><returnType><INT/></returnType></interface><GetAccessor>"
        "<interface/><body>" + text("Half := n / 2;") + "</body></GetAccessor></Property>"
    )
    inherits = (
        "<interface><addData><data name='x'><Inheritance><Extends>Base</Extends></Inheritance>"
        "</data></addData></interface>"
    )
    block = pou("FB_X", inherits, text(""), "functionBlock").replace(
        "</pou>", f"<addData><data name='m'>{method}</data><data name='p'>{property}</data>"
        "</addData></pou>",
    )  # fmt: skip
    body = text("r := f.Add(d := 6);\nh := f.Half;")
    plc = program(body, base, block, r="INT", h="INT", f=".FB_X")
    plc.rows("", "r h", [" | 6 3", " | 12 6"])


def test_interface_of_a_vendor_is_a_unit() -> None:
    added = (
        "<addData><data name='x/interface'><Interface name='I_X'><Methods><Method name='Run'>"
        "<interface/></Method></Methods></Interface></data></addData>"
    )
    whole = document().replace("</project>", added + "</project>")
    (unit,) = parse_plcopen(whole.encode(), "plc.xml", "plc").units
    assert isinstance(unit, units.Interface)
    assert [part.name for part in unit.parts] == ["Run"]


def test_instruction_list() -> None:
    body = text("LD a\nJMPC on\nLD 1\nJMP out\non: LD 5\nout:\nST q\n", "IL")
    program(body, a="BOOL", q="INT").rows("a", "q", ["0 | 1", "1 | 5"])


def test_tasks_have_cycle_priority_and_programs() -> None:
    fast, slow, free = tasks_of_plcopen(document(instances=TASKS).encode(), "plc.xml")
    assert (fast.name, fast.cycle_ns, fast.priority, fast.programs) == (
        "fast", 20_000_000, 1, ("MAIN",)
    )  # fmt: skip
    assert (slow.cycle_ns, slow.programs) == (500_000_000, ("MAIN",))
    assert (free.cycle_ns, free.priority, free.programs) == (10_000_000, 20, ())


@pytest.mark.parametrize(
    ("data", "expected"), [(document().encode(), True), (b"<project/>", False), (b"", False)]
)
def test_documents_are_known_by_their_beginning(data: bytes, expected: bool) -> None:
    assert is_plcopen(data) is expected


def test_document_without_units_is_a_fault_of_nothing() -> None:
    assert parse_plcopen(document().encode(), "plc.xml", "plc").units == ()


@pytest.mark.parametrize("interval", [f"PT{'9' * 400}S", "PT1H\u00b2M", "T#1e9", "-1"])
def test_interval_that_cannot_be_is_the_usual_one(interval: str) -> None:
    tasks = TASKS.replace("T#20ms", interval).replace('priority="1"', f'priority="{"9" * 5000}"')
    task = tasks_of_plcopen(document(instances=tasks).encode(), "plc.xml")[0]
    assert (task.cycle_ns, task.priority) == (10_000_000, 20)
