"""Records of fleets: one of a name, gone with its supervisor."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from achse.cli.start import fleet_record
from achse.cli.start.fleet_record import (
    FleetRecord,
    fleet_logs,
    fleet_recorded,
    fleets,
    the_fleet,
    until_gone,
)

FIRST = FleetRecord("press", "/x/fleet.toml", 7, 1, "key")
SECOND = FleetRecord("saws", "/y/fleet.toml", 8, 2, "key")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ACHSE_RUNTIME_DIR", str(tmp_path / "run"))
    return tmp_path / "run"


def test_a_fleet_is_found_by_name_and_file_while_it_runs(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with fleet_recorded(FIRST):
        assert the_fleet(None) == FIRST
        with fleet_recorded(SECOND):
            assert fleets() == [FIRST, SECOND]
            assert the_fleet("saws") == SECOND
            assert the_fleet("/x/fleet.toml") == FIRST
            for wrong in (None, "other"):
                with pytest.raises(typer.Exit):
                    the_fleet(wrong)
            assert "press, saws" in capsys.readouterr().err
    assert fleets() == []
    with pytest.raises(typer.Exit):
        the_fleet(None)
    assert "no fleet runs" in capsys.readouterr().err
    assert fleet_logs("press").parent == folder


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has other rights of files")
def test_only_the_user_reads_the_key(folder: Path) -> None:
    with fleet_recorded(FIRST):
        [file] = folder.glob("*.json")
        assert file.stat().st_mode & 0o077 == 0


def test_one_of_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    with fleet_recorded(FIRST), pytest.raises(typer.Exit), fleet_recorded(FIRST):
        pass
    assert "runs already, supervisor in process 7" in capsys.readouterr().err


def test_of_two_that_start_at_the_same_time_one_gets_the_name(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with fleet_recorded(FIRST):
        with monkeypatch.context() as at_once:
            at_once.setattr(fleet_record, "fleets", list)
            with pytest.raises(typer.Exit), fleet_recorded(FIRST):
                pass
        assert "being started by another" in capsys.readouterr().err
        assert fleets() == [FIRST]
        assert [file.name for file in folder.iterdir()] == ["fleet-press.json"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows removes no files that are open")
def test_a_fleet_is_gone_when_its_process_has_ended(folder: Path) -> None:
    program = (
        "import sys; from achse.cli.start.fleet_record import *\n"
        "with fleet_recorded(FleetRecord('press', 'f', 1, 2, 'k')):\n"
        "    print(flush=True); sys.stdin.readline()\n"
        "print(flush=True); sys.stdin.readline()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        with until_gone(fleets()[0]) as gone:
            assert not gone()
            process.stdin.write("\n")
            process.stdin.flush()
            process.stdout.readline()
            assert fleets() == []
            assert not gone()
            process.communicate("\n")
            assert gone()
    with until_gone(FIRST) as gone:
        assert gone()


def test_the_record_of_a_killed_supervisor_is_removed(folder: Path) -> None:
    program = (
        "import os; from achse.cli.start.fleet_record import *\n"
        "with fleet_recorded(FleetRecord('press', 'f', 1, 2, 'k')): os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", program], env=os.environ.copy()).returncode == 9
    assert list(folder.glob("fleet-press.json"))
    assert fleets() == []
    assert not list(folder.glob("fleet-press.json"))


def test_garbage_is_left_out(folder: Path) -> None:
    folder.mkdir()
    (folder / "fleet-x.json").write_text("{")
    assert fleets() == []


def test_a_supervisor_that_does_not_answer_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit):
        FIRST.order("status")
    assert "the supervisor of press, process 7" in capsys.readouterr().err
