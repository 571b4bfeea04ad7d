"""Recursion of any shape on stacks of any size: as plain code, or STACK_OVERFLOW, never a crash."""

from typing import NamedTuple, TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.native.backend import compiler_installed
from achse.plc.code.execution import CodeForm
from tests.native.backend.stacks import in_thread
from tests.plc.code.conftest import Ran

pytestmark = pytest.mark.skipif(not compiler_installed(), reason="llvmlite is not installed")

T = TypeVar("T")
KB = 1 << 10
AMPLE = 128 * KB * KB

TYPES = {
    "LINT": "{0} := n + {1};|s := s XOR {0};",
    "INT": "{0} := LINT_TO_INT(n * {1});|s := s + {0};",
    "LREAL": "{0} := LINT_TO_LREAL(n) * 0.5;|s := s + LREAL_TO_LINT({0});",
    "BOOL": "{0} := n > {1};|IF {0} THEN s := s + 1; END_IF",
    "STRING(20)": "{0} := LINT_TO_STRING(n);|s := s + LEN({0});",
    "STRING(250)": "{0} := CONCAT('ab', LINT_TO_STRING(n));|s := s + FIND({0}, 'b');",
    "WSTRING(9)": '{0} := "xy";|s := s + WLEN({0});',
    "T_Pair": "{0}.a := n;|s := s + {0}.a;",
    "ARRAY[0..7] OF LINT": "{0}[3] := n;|s := s + {0}[3];",
    "ARRAY[0..900] OF INT": "{0}[LINT_TO_INT(n MOD 900)] := 5;|s := s + {0}[n MOD 900];",
}
"""Of locals: what is done before the call, and after it."""

VALUES = {
    "LINT": "n", "SINT": "LINT_TO_SINT(n MOD 100)", "LREAL": "LINT_TO_LREAL(n)", "BOOL": "n > 5",
    "STRING(12)": "LINT_TO_STRING(n)", "STRING": "'by value'", "T_Pair": "pair",
    "ARRAY[0..7] OF LINT": "eight",
}  # fmt: skip
"""Of parameters by value: what is passed."""

CALLS = {
    "function": "F{0}({1})",
    "method": "GVL.object.M{0}({1})",
    "interface": "GVL.face.M{0}({1})",
    "body": "B{0}({1})",
    "python": "F{0}({1})",
}


class Link(NamedTuple):
    """A routine of the recursion, which calls the next one."""

    kind: str
    locals: list[tuple[str, int]]
    values: list[str]
    width: int
    """Terms of an expression around the call: their values are kept meanwhile."""
    catches: bool


LINKS = st.builds(
    Link,
    st.sampled_from(list(CALLS)),
    st.lists(
        st.tuples(st.sampled_from(list(TYPES)), st.sampled_from([1, 2, 5, 40])), max_size=3
    ).flatmap(lambda some: st.sampled_from([some, [*some, ("LINT", 600)], [*some, ("BOOL", 100)]])),
    st.lists(st.sampled_from(list(VALUES)), max_size=5),
    st.sampled_from([0, 1, 5, 40]),
    st.sampled_from([False, False, False, True]),
)
DEPTHS = st.one_of(st.integers(0, 60), st.integers(60, 1500), st.just(6000))
SIZES = st.sampled_from([128 * KB, 256 * KB, 1024 * KB, 8192 * KB])


def _routine(number: int, links: list[Link]) -> tuple[str, str]:
    """A routine outside of blocks, and a method of the block; one of them is empty."""
    link, after = links[number], links[(number + 1) % len(links)]
    names = [
        (type, f"v{place}_{each}")
        for place, (type, count) in enumerate(link.locals)
        for each in range(count)
    ]
    arguments = ["n - 1", *(VALUES[type] for type in after.values)]
    call = CALLS[after.kind].format((number + 1) % len(links), ", ".join(arguments))
    before, behind = (
        "\n".join(
            TYPES[type].split("|")[half].format(name, at) for at, (type, name) in enumerate(names)
        )
        for half in (0, 1)
    )
    terms = "".join(f" + (n / (n + {each}))" for each in range(1, link.width + 1))
    step = f"s := s + (n * 3{terms} + {call}{terms});"
    if link.catches:
        step = f"__TRY {step} __CATCH(c) s := s + 1; GVL.caught := GVL.caught + 1; __ENDTRY"
    if link.kind == "python":
        step = f"p := __NEW(LINT); p^ := n; __DELETE(p); {step}"
    inputs = " ".join(["n : LINT;", *(f"i{at} : {type};" for at, type in enumerate(link.values))])
    variables = (
        "s : LINT; pair : T_Pair; eight : ARRAY[0..7] OF LINT; p : POINTER TO LINT;"
        " c : __SYSTEM.ExceptionCode; "
    ) + " ".join(f"{name} : {type};" for type, name in names)
    head = f"VAR_INPUT {inputs} END_VAR\nVAR {variables} END_VAR\n"
    text = f"pair.a := n;\n{before}\nIF n > 0 THEN {step} END_IF\n{behind}\n"
    name = CALLS[link.kind].split(".")[-1].split("{")[0] + str(number)
    if link.kind in ("method", "interface"):
        return "", f"METHOD {name} : LINT\n{head}{text}{name} := s;\nEND_METHOD\n"
    if link.kind == "body":
        return (
            f"FUNCTION_BLOCK FB_{name}\nVAR_TEMP n : LINT; {variables} END_VAR\n"
            f"n := GVL.depth;\n{text}GVL.result := s;\nEND_FUNCTION_BLOCK\n"
            f"VAR_GLOBAL body{number} : FB_{name}; END_VAR\n"
            f"FUNCTION {name} : LINT\nVAR_INPUT {inputs} END_VAR\n"
            f"GVL.depth := n; GVL.body{number}(); {name} := GVL.result;\nEND_FUNCTION\n"
        ), ""
    return f"FUNCTION {name} : LINT\n{head}{text}{name} := s;\nEND_FUNCTION\n", ""


def program(links: list[Link]) -> str:
    """A program that calls the first routine, `depth` calls deep."""
    parts = [_routine(number, links) for number in range(len(links))]
    methods = "".join(method for _, method in parts)
    abstract = "".join(
        method.split("\nVAR s")[0] + "\nEND_METHOD\n" for _, method in parts if method
    )
    arguments = ["depth", *(VALUES[type] for type in links[0].values)]
    return (
        "TYPE T_Pair : STRUCT a : LINT; b : LREAL; END_STRUCT END_TYPE\n"
        f"INTERFACE I_Face\n{abstract}END_INTERFACE\n"
        f"FUNCTION_BLOCK FB_Face IMPLEMENTS I_Face\n{methods}END_FUNCTION_BLOCK\n"
        "VAR_GLOBAL object : FB_Face; face : I_Face; depth : LINT; result : LINT; caught : LINT;"
        " END_VAR\n"
        + "".join(routine for routine, _ in parts)
        + "PROGRAM MAIN\n"
        "VAR depth : LINT; got : LINT; caught : LINT; n : LINT := 7; pair : T_Pair;"
        " eight : ARRAY[0..7] OF LINT; END_VAR\n"
        f"GVL.face := GVL.object; GVL.caught := 0;\ngot := {CALLS[links[0].kind]}".format(
            0, ", ".join(arguments)
        )
        + ";\ncaught := GVL.caught;\nEND_PROGRAM"
    )


def outcome(ran: Ran, depth: int) -> tuple[int, int] | str:
    """Result and number of exceptions caught after one cycle from a reset, or the exception."""
    ran.plc.reset()
    ran.plc.run()
    ran.plc.instance("MAIN")["depth"] = depth
    ran.cycle()
    if ran.plc.fault is None:
        return ran["got"], ran["caught"]
    return ran.stopped.name


@settings(max_examples=5)
@given(
    st.lists(LINKS, min_size=1, max_size=3),
    st.lists(st.tuples(DEPTHS, SIZES), min_size=1, max_size=3),
)
def test_recursion_ends_as_plain_code_or_by_a_stack_overflow(
    links: list[Link], calls: list[tuple[int, int]]
) -> None:
    text = program(links)
    plain = Ran(text, CodeForm.PLAIN)
    machine = Ran(text, CodeForm.MACHINE, has_twin=False)
    for number, link in enumerate(links):
        assert (f"f{number}" in machine.plain_routines) == (link.kind == "python")
    catches = any(link.catches for link in links)
    mixed = any(link.kind == "python" for link in links)
    for depth, size in calls:
        usual = outcome(plain, depth)
        ample = in_thread(AMPLE, lambda n=depth: outcome(machine, n))  # type: ignore[misc]
        tight = in_thread(size, lambda n=depth: outcome(machine, n))  # type: ignore[misc]
        if "STACK_OVERFLOW" not in (usual, ample) and not catches:
            assert ample == usual
        if depth <= 60 or (depth <= 600 and not mixed):
            assert ample == usual
        if not catches:
            assert tight in (ample, "STACK_OVERFLOW")


@pytest.mark.parametrize("count", [520, 16_384])
def test_recursion_with_many_locals_is_a_stack_overflow(count: int) -> None:
    """520 LINT ended the process once: their places on the stack were not counted."""
    names = ", ".join(f"v{number}" for number in range(count))
    machine = Ran(
        "FUNCTION Down : LINT\nVAR_INPUT n : LINT; END_VAR\n"
        f"VAR {names} : LINT; END_VAR\nv0 := n; v{count - 1} := n;\n"
        "IF n > 0 THEN v0 := Down(n - 1); END_IF\n"
        f"Down := v{count - 1} + v0;\nEND_FUNCTION\n"
        "PROGRAM MAIN VAR depth, got, caught : LINT; END_VAR got := Down(depth); END_PROGRAM",
        CodeForm.MACHINE,
        has_twin=False,
    )
    assert not machine.plain_routines
    assert outcome(machine, 6000) == "STACK_OVERFLOW"
    assert in_thread(8192 * KB, lambda: outcome(machine, 30)) == (465, 0)
    assert in_thread(128 * KB, lambda: outcome(machine, 6000)) == "STACK_OVERFLOW"


def test_calls_with_more_parameters_than_the_stack_holds_stay_plain() -> None:
    names = ", ".join(f"v{number}" for number in range(501))
    ran = Ran(
        f"FUNCTION Many : LINT\nVAR_INPUT {names} : LINT; END_VAR\nMany := v0 + v500;\n"
        "END_FUNCTION\nPROGRAM MAIN VAR got : LINT; END_VAR\n"
        "got := Many(v0 := 3, v500 := 4);\nEND_PROGRAM",
        CodeForm.MACHINE,
    ).cycle()
    assert ran["got"] == 7
    assert dict(ran.plain_routines) == dict.fromkeys(
        ("many", "main"), "more than 500 parameters are on the stack"
    )
