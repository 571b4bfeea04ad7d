"""Trial of a PLC: the verdict after its first cycles."""

from pathlib import Path

import pytest

from achse.cli.test.trial import TrialResult, try_project
from achse.plc import Task
from achse.plc.system_info import system_info_list
from achse.st.check import check
from achse.st.project import examine_project

TASK = """<TcPlcObject><Task Name="{name}"><CycleTime>{cycle}</CycleTime><Priority>20</Priority>
<PouCall><Name>{program}</Name></PouCall></Task></TcPlcObject>"""


def tried(folder: Path, text: str, *tasks: tuple[str, int, str]) -> TrialResult:
    (folder / "main.st").write_text(text)
    for name, cycle, program in tasks:
        file = folder / f"{name}.TcTTO"
        file.write_text(TASK.format(name=name, cycle=cycle, program=program))
    project, error = examine_project(folder)
    system = system_info_list([Task()], app_name="", project_name="", port=851, timestamp=0)
    typed = check(
        project.declarations, predefined=[system], reach=project.reach, unreached=project.unreached
    )
    assert error is None
    assert not typed.faults
    return try_project(project, typed)


@pytest.mark.parametrize("cycle", [1, 2, 3])
def test_program_that_stops_in_its_first_cycles_would_not_run(tmp_path: Path, cycle: int) -> None:
    verdict = tried(
        tmp_path,
        f"PROGRAM MAIN\nVAR n, d : INT; END_VAR\nn := n + 1;\nd := 1 / ({cycle} - n);\nEND_PROGRAM",
    )
    assert not verdict.runs
    assert str(verdict).startswith(f"would not run: task PlcTask stopped in cycle {cycle}: ")
    assert "main.st, line 4" in verdict.text


def test_program_that_runs_says_which_task_calls_it(tmp_path: Path) -> None:
    verdict = tried(
        tmp_path, "PROGRAM P\nEND_PROGRAM\nPROGRAM Q\nEND_PROGRAM", ("T", 5000, "P"),
        ("S", 1000, "Q"),
    )  # fmt: skip
    assert str(verdict) == "would run: S (Q), T (P), 3 cycles tried"


def test_slow_task_runs_its_first_cycle(tmp_path: Path) -> None:
    verdict = tried(
        tmp_path,
        "PROGRAM P\nEND_PROGRAM\nPROGRAM Q\nVAR n : INT; END_VAR\nn := 1 / n;\nEND_PROGRAM",
        ("Fast", 1000, "P"),
        ("Slow", 100_000_000, "Q"),
    )
    assert "task Slow stopped in cycle 1" in verdict.text


def test_task_that_calls_an_unknown_program_would_not_run(tmp_path: Path) -> None:
    verdict = tried(tmp_path, "PROGRAM P\nEND_PROGRAM", ("T", 1000, "Missing"))
    assert verdict == (False, "task T calls 'Missing', which is not declared")


def test_library_has_nothing_to_run(tmp_path: Path) -> None:
    verdict = tried(tmp_path, "FUNCTION_BLOCK B\nEND_FUNCTION_BLOCK")
    assert verdict == (True, "there is nothing to run, no task calls a program")


def test_address_that_is_no_bit_would_not_run(tmp_path: Path) -> None:
    verdict = tried(
        tmp_path, "PROGRAM P\nVAR n AT %IX0.1 : INT; END_VAR\nEND_PROGRAM", ("T", 1000, "P")
    )
    assert not verdict.runs
    assert "a bit address takes BOOL" in verdict.text


def test_start_that_fails_would_not_run(tmp_path: Path) -> None:
    verdict = tried(
        tmp_path,
        "FUNCTION F : INT\nVAR z : INT; END_VAR\nF := 1 / z;\nEND_FUNCTION\n"
        "PROGRAM P\nVAR n : INT := F(); END_VAR\nEND_PROGRAM",
    )
    assert "the start failed" in verdict.text
