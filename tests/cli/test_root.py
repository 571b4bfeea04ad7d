"""`achse run` is the same command whether the others are there or not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import achse.cli
from achse.cli.app import app
from achse.cli.front import PANELS
from achse.cli.root import new_root
from achse.cli.start import run


@pytest.mark.parametrize(
    "words", [("run", "--help"), ("run", "--speed"), ("run", "--nothing"), ("--version",)]
)
def test_it_is_reported_the_same(words: tuple[str, ...]) -> None:
    alone = new_root()
    run.register(alone)
    outcomes = [CliRunner().invoke(each, words, prog_name="achse") for each in (app, alone)]
    assert outcomes[0].output == outcomes[1].output
    assert outcomes[0].exit_code == outcomes[1].exit_code


def test_a_start_loads_no_other_commands() -> None:
    program = (
        "import sys, achse.cli as cli; cli._commands(['run']);"
        " print([name for name in sys.modules if name.startswith('achse.cli.ad')])"
    )
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=os.environ
    )
    assert result.stdout.strip() == "[]", result.stderr


def test_help_has_a_panel_for_each_command() -> None:
    stdout = CliRunner().invoke(app, ["--help"]).stdout
    places = [stdout.index(f"─ {panel} ─") for panel in PANELS]
    assert places == sorted(places)
    commands = set(get_command(app).commands)  # type: ignore[attr-defined]
    assert commands == {name for names in PANELS.values() for name in names}


def test_each_panel_is_a_room() -> None:
    inside = Path(achse.cli.__file__).parent.iterdir()
    rooms = {place.name for place in inside if (place / "__init__.py").is_file()}
    assert {panel.lower() for panel in PANELS} == rooms
