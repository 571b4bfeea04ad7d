"""Exports of TwinCAT 2: units, actions, lists and tasks in one text."""

import pytest

from achse.st.files.exports import parse_export, tasks_of_export
from achse.st.graphical.body import GraphicalBody
from achse.st.syntax import units
from achse.st.syntax.parser import parse
from tests.st.graphical.drawings import Drawn

HEAD = "(* @NESTEDCOMMENTS := 'Yes' *)\n(* @PATH := '\\/Bas' *)\n"
DECLARED = "(* @END_DECLARATION := '0' *)\n"
COUNTER = (
    HEAD + "FUNCTION_BLOCK Counter (* END_FUNCTION_BLOCK (* nested *) *)\nVAR_INPUT up : BOOL;"
    " END_VAR\nVAR_OUTPUT n : INT; END_VAR\n" + DECLARED + "IF up THEN\n  Add();\nEND_IF\n"
    "END_FUNCTION_BLOCK\n\nACTION Add:\nn := n + 1;\nEND_ACTION\n"
)
MAIN = (
    HEAD + "PROGRAM MAIN\nVAR up : BOOL; c : Counter; END_VAR\n" + DECLARED + "c(up := up);\n"
    "total := c.n;\nEND_PROGRAM\n"
)
LISTS = (
    HEAD
    + "(* @GLOBAL_VARIABLE_LIST := 'Global Variables' *)\nVAR_GLOBAL\n  total : INT;\nEND_VAR\n"
    "(* @OBJECT_END := 'Global Variables' *)\nVAR_GLOBAL CONSTANT\n  limit : INT := 3;\nEND_VAR\n"
)
TASKS = (
    "RESOURCE\n\nTASK Fast (PRIORITY := 1, INTERVAL := T#1s200ms);\nMAIN();\nOther();\n"
    "{Additional_info : 1,0}\nEND_TASK\n\nTASK Free (PRIORITY := 31);\nSlow();\nEND_TASK\n"
    "{event_task : 'start','','FUNCTION systemevent: DWORD'}\nEND_RESOURCE\n"
)
LIBRARY = "LIBRARY\nSTANDARD.LIB 2.6.14\nNumOfPOUs: 1\nTYPE: 0\nEND_LIBRARY\n"


def test_objects_of_an_export_run_together() -> None:
    text = LIBRARY + LISTS + COUNTER + "VISUALISATION a\nit's\nEND_VISUALISATION\n" + MAIN + TASKS
    parsed = parse_export(text, "all.exp", "all")
    assert not parsed.faults
    plc = Drawn(parsed)
    plc.rows("up", "c.n", ["1 | 1", "1 | 2", "0 | 2"])


def test_blocks_of_a_list_become_one_list() -> None:
    parsed = parse_export(LISTS, "LIST.EXP", "LIST")
    (unit,) = parsed.units
    assert isinstance(unit, units.GlobalList)
    assert unit.name == "Global_Variables"
    assert [block.qualifiers for block in unit.blocks] == [(), ("CONSTANT",)]


def test_units_are_those_of_the_same_text() -> None:
    assert parse_export(COUNTER, "A.EXP", "A").units == parse(COUNTER).units


def test_faults_have_their_line() -> None:
    parsed = parse_export(HEAD + MAIN.replace("c.n;", "c.;"), "MAIN.EXP", "MAIN")
    assert [fault.location.line for fault in parsed.faults] == [9]


def test_action_without_a_unit_is_a_fault() -> None:
    parsed = parse_export("ACTION Add:\nn := 1;\nEND_ACTION\n", "A.EXP", "A")
    assert ["an ACTION without a unit" in fault.message for fault in parsed.faults] == [True]


def test_tasks_have_cycle_priority_and_programs() -> None:
    fast, free = tasks_of_export(MAIN + TASKS)
    assert (fast.name, fast.cycle_ns, fast.priority) == ("Fast", 1_200_000_000, 1)
    assert fast.programs == ("MAIN", "Other")
    assert (free.cycle_ns, free.priority, free.programs) == (10_000_000, 31, ("Slow",))


@pytest.mark.parametrize(
    ("body", "language"),
    [
        ("LD a\nST b\n", "EXP_IL"),
        ("again: (* first *)\n  LDN a\nST b\n", "EXP_IL"),
        ("CAL t(IN := a)\n", "EXP_IL"),
        ("_LD_BODY\n_NETWORKS : 0\n", "EXP_LD"),
        ("_FBD_BODY\n_NETWORKS : 0\n", "EXP_FBD"),
        ("_CFC_BODY\n", "EXP_CFC"),
        ("INITIAL_STEP Init:\nEND_STEP\n", "EXP_SFC"),
        ("ld := a;\n", ""),
        ("LD(a);\n", ""),
        ("", ""),
    ],
)
def test_body_shows_its_language(body: str, language: str) -> None:
    text = HEAD + "PROGRAM MAIN\nVAR a, b : BOOL; END_VAR\n" + DECLARED + body + "END_PROGRAM\n"
    (unit,) = parse_export(text, "MAIN.EXP", "MAIN").units
    assert isinstance(unit, units.Program)
    shown = unit.body.language if isinstance(unit.body, GraphicalBody) else ""
    assert shown == language


def test_place_in_a_drawn_body_is_its_line() -> None:
    text = HEAD + "PROGRAM MAIN\nVAR END_VAR\n" + DECLARED + "_CFC_BODY\n_ELEMENT\nEND_PROGRAM\n"
    parsed = parse_export(text, "MAIN.EXP", "MAIN")
    (drawing,) = parsed.source.drawings
    assert parsed.source.locate(drawing.start + len("_CFC_BODY\n")).line == 7


def test_drawn_action_belongs_to_its_unit() -> None:
    text = (
        HEAD + "PROGRAM MAIN\nVAR a, b : BOOL; END_VAR\n" + DECLARED + "Copy();\nEND_PROGRAM\n"
        "ACTION Copy:\nLD a\nST b\nEND_ACTION\n"
    )
    Drawn(parse_export(text, "MAIN.EXP", "MAIN")).rows("a", "b", ["1 | 1", "0 | 0"])


def test_place_of_hardware_is_left_to_the_station() -> None:
    text = "VAR_GLOBAL\n  a AT %QW9.1.0 : WORD;\nEND_VAR\n" + MAIN + COUNTER + LISTS
    parsed = parse_export(text, "all.exp", "all")
    Drawn(parsed).rows("up", "c.n", ["1 | 1"])


def test_tasks_without_an_end_are_left_out() -> None:
    heads = "TASK a (PRIORITY := 1);\n" * 20_000  # each of them once read the file to its end
    (task,) = tasks_of_export(f"RESOURCE r\nTASK t ();\nMAIN();\nEND_TASK\n{heads}END_RESOURCE")
    assert (task.name, task.programs) == ("t", ("MAIN",))


@pytest.mark.parametrize("priority", ["9" * 5000, "-", "x", "1e3"])
def test_priority_that_is_no_number_is_the_usual_one(priority: str) -> None:
    text = f"RESOURCE r\nTASK t (PRIORITY := {priority});\nEND_TASK\nEND_RESOURCE"
    assert tasks_of_export(text)[0].priority == 20
