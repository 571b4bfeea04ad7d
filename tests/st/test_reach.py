"""Reach: faults of units that no task reaches are no errors, all others are."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.lexis.source import SourceError
from achse.st.project import Project, examine_project
from achse.station import Station
from achse.station.configuration.station_file import parse

TASK = """<TcPlcObject><Task Name="PlcTask"><CycleTime>10000</CycleTime><Priority>20</Priority>
{calls}</Task></TcPlcObject>"""
_FAULTS = {
    "type": ("v : Nothing;", ""),
    "body": ("", "nothing := 1;"),
    "syntax": ("", "n := ;"),
    "head": ("v : ;", ""),
}
_MENTIONS = ("block", "pointer", "method", "list", "size", "value")


def _task(*programs: str) -> str:
    return TASK.format(calls="".join(f"<PouCall><Name>{p}</Name></PouCall>" for p in programs))


def _examined(folder: Path, files: dict[str, str]) -> tuple[Project, list[str], list[str]]:
    """Return the project, and the units with errors and with unreached faults, by their files."""
    from achse.st.check import check

    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    project, error = examine_project(folder)
    typed = check(project.declarations, reach=project.reach, unreached=project.unreached)
    errors = [*(error.faults if error else ()), *typed.faults]
    unreached = {*project.unreached, *typed.unreached}
    for file in files:
        (folder / file).unlink()
    return (
        project,
        sorted({Path(fault.location.path).stem for fault in errors}),
        sorted({Path(fault.location.path).stem for fault in unreached}),
    )


def _unit(number: int, fault: str, names: dict[int, str]) -> dict[str, str]:
    """Return the files of block `number` with a fault, which names other blocks."""
    variables, body = _FAULTS.get(fault, ("", ""))
    files = {}
    methods = ""
    for other, way in names.items():
        block = f"FB{other}"
        if way == "block":
            variables += (
                f" f{other} : {block};" if other > number else f" f{other} : REFERENCE TO {block};"
            )
        elif way == "pointer":
            variables += f" p{other} : POINTER TO {block};"
        elif way == "method":
            methods += f"METHOD m{other} VAR_INPUT r : REFERENCE TO {block}; END_VAR END_METHOD\n"
        elif way == "list":
            files[f"L{number}_{other}.st"] = (
                f"VAR_GLOBAL g{number}_{other} : POINTER TO {block}; END_VAR"
            )
            body = f"n := SIZEOF(g{number}_{other}); {body}"
        elif way == "size":
            body = f"n := SIZEOF({block}); {body}"
        else:
            body = f"n := V{other}; {body}"
    files[f"FB{number}.st"] = (
        f"FUNCTION_BLOCK FB{number} VAR n : UDINT; {variables} END_VAR\n{methods}{body}\n"
        "END_FUNCTION_BLOCK"
    )
    files[f"E{number}.st"] = f"TYPE E{number} : (V{number}) UDINT; END_TYPE"
    return files


@given(
    st.integers(1, 4).flatmap(
        lambda count: st.tuples(
            st.lists(st.sampled_from(("", "", *_FAULTS)), min_size=count, max_size=count),
            st.dictionaries(
                st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)),
                st.sampled_from(_MENTIONS),
                max_size=8,
            ),
            st.sets(st.integers(0, count - 1), max_size=2),
        )
    )
)
def test_faults_are_errors_where_a_task_leads(
    tmp_path_factory: pytest.TempPathFactory,
    drawn: tuple[list[str], dict[tuple[int, int], str], set[int]],
) -> None:
    faults, edges, roots = drawn
    files = {"PlcTask.TcTTO": _task("MAIN")}
    for number, fault in enumerate(faults):
        names = {to: way for (here, to), way in edges.items() if here == number != to}
        files |= _unit(number, fault, names)
    calls = " ".join(f"f{number} : FB{number};" for number in roots)
    files["MAIN.st"] = f"PROGRAM MAIN VAR {calls} END_VAR END_PROGRAM"
    reached = set(roots)
    for _ in faults:
        reached |= {to for (here, to), way in edges.items() if here in reached and way != "value"}
    _, errors, unreached = _examined(tmp_path_factory.mktemp("reach"), files)
    faulty = {number for number, fault in enumerate(faults) if fault}
    assert errors == [f"FB{number}" for number in sorted(faulty & reached)]
    assert unreached == [f"FB{number}" for number in sorted(faulty - reached)]


OLD = "FUNCTION_BLOCK OLD VAR v : Nothing; END_VAR END_FUNCTION_BLOCK"


@pytest.mark.parametrize("tasks", [(), ("Missing",)])
def test_without_a_called_program_all_units_are_reached(
    tmp_path: Path, tasks: tuple[str, ...]
) -> None:
    files = {"MAIN.st": "PROGRAM MAIN END_PROGRAM", "OLD.st": OLD}
    if tasks:
        files["PlcTask.TcTTO"] = _task(*tasks)
    assert _examined(tmp_path, files)[1:] == (["OLD"], [])


def test_unreached_unit_leaves_out_what_depends_on_it(tmp_path: Path) -> None:
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "MAIN.st": "PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM",
        "OLD.st": OLD,
        "G.st": "VAR_GLOBAL o : OLD; END_VAR",
        "GOOD.st": "VAR_GLOBAL n : INT; END_VAR",
    }
    project, errors, unreached = _examined(tmp_path, files)
    assert (errors, unreached) == ([], ["OLD"])
    assert [unit.__iec__.name for unit in project.declarations.units] == ["GOOD", "MAIN"]


def test_station_runs_where_an_unreached_unit_points_at_a_type_at_fault(tmp_path: Path) -> None:
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "MAIN.st": "PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM",
        "OLD.st": OLD,
        "ST.st": "TYPE ST : STRUCT p : POINTER TO OLD; r : REFERENCE TO OLD; END_STRUCT END_TYPE",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "."}]}, "a.toml"), base=tmp_path)
    station.advance(0.1)
    assert station.plcs[851].failure == ""
    assert station.plcs[851].instance("MAIN")["n"] > 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("CheckBounds", "FUNCTION CheckBounds : DINT nothing := 1; END_FUNCTION"),
        ("P2", "{attribute 'linkalways'} PROGRAM P2 nothing := 1; END_PROGRAM"),
        (
            "F_Init",
            "{attribute 'call_after_global_init_slot' := '50000'}"
            " FUNCTION F_Init : INT nothing := 1; END_FUNCTION",
        ),
        ("Config", "VAR_CONFIG MAIN.x AT %QX0.0 : BOOL; END_VAR"),
    ],
)
def test_units_that_the_runtime_finds_are_reached(tmp_path: Path, name: str, text: str) -> None:
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "MAIN.st": "PROGRAM MAIN END_PROGRAM",
        f"{name}.st": text,
    }
    assert _examined(tmp_path, files)[1:] == ([name], [])


def test_file_that_cannot_be_read_is_an_error_if_its_name_is_used(tmp_path: Path) -> None:
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "MAIN.st": "PROGRAM MAIN VAR f : USED; END_VAR f(); END_PROGRAM",
        "USED.TcPOU": "<TcPlcObject><POU",
        "OLD.TcPOU": "<TcPlcObject><POU",
    }
    assert _examined(tmp_path, files)[1:] == (["MAIN", "USED"], ["OLD"])


def test_broken_task_is_an_error(tmp_path: Path) -> None:
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "Other.TcTTO": "<TcPlcObject><Task",
        "MAIN.st": "PROGRAM MAIN END_PROGRAM",
    }
    assert _examined(tmp_path, files)[1:] == (["Other"], [])


def test_all_units_are_checked_on_request(tmp_path: Path) -> None:
    (tmp_path / "PlcTask.TcTTO").write_text(_task("MAIN"))
    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN END_PROGRAM")
    (tmp_path / "OLD.st").write_text(OLD)
    assert examine_project(tmp_path)[1] is None
    assert isinstance(examine_project(tmp_path, check_all=True)[1], SourceError)
    assert isinstance(examine_project(tmp_path, programs=["OTHER"])[1], SourceError)


def test_faulty_drawn_body_counts_where_it_is_reached(tmp_path: Path) -> None:
    unit = (
        '<TcPlcObject><POU Name="{0}"><Declaration><![CDATA[FUNCTION_BLOCK {0}{1}]]></Declaration>'
        "<Implementation><NWL><o>{2}</o></NWL></Implementation></POU></TcPlcObject>"
    )
    files = {
        "PlcTask.TcTTO": _task("MAIN"),
        "MAIN.st": "PROGRAM MAIN VAR d : DRAWN; END_VAR END_PROGRAM",
        "DRAWN.TcPOU": unit.format("DRAWN", "", "USED"),
        "USED.TcPOU": unit.format("USED", " VAR v : Nothing; END_VAR", ""),
        "OLD.TcPOU": unit.format("OLD", " VAR v : Nothing; END_VAR", "USED"),
    }
    assert _examined(tmp_path, files)[1:] == (["USED"], ["OLD"])
