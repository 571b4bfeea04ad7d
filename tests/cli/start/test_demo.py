"""`achse demo`: it goes through to its end, and leaves nothing behind."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import typer

import achse.web
from achse.cli.start import demo
from achse.cli.start.demo import STEPS, DemoStep
from tests.warm_commands import WarmCommands

IN_WARM_PROCESS = "import sys; sys.executable = {!r}; from achse.__main__ import main; main()"
"""The demo itself is a real process; the commands that it starts are forked."""


def test_it_goes_through(tmp_path: Path, warm_commands: WarmCommands) -> None:
    program = IN_WARM_PROCESS.format(str(warm_commands.python))
    run = subprocess.run(
        [sys.executable, "-c", program, "demo", "--yes"],
        cwd=tmp_path,
        env=os.environ | {"TMPDIR": str(tmp_path), "TEMP": str(tmp_path), "NO_COLOR": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert run.returncode == 0, run.stdout + run.stderr
    commands = re.findall(r"^\$ achse (.*)$", run.stdout, re.MULTILINE)
    assert commands == [command for step in STEPS for command in step.commands]
    assert "X: 0.000 → 100." in run.stdout
    assert "move.scope: 2 channels, 2000 samples" in run.stdout
    assert "0x706 INVALID_DATA" in run.stderr
    assert run.stdout.count("GVL.nInt = -16") == 1
    assert "next:  achse run" in run.stdout
    assert list(tmp_path.iterdir()) == []


def test_its_pages_are_there() -> None:
    pages = Path(achse.web.__file__).parent / "pages" / "pages.js"
    known = set(re.findall(r'\bname: "(\w+)"', pages.read_text(encoding="utf-8")))
    assert {step.page for step in STEPS} <= known


def test_a_step_that_fails_ends_it(
    warm_commands: WarmCommands, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "executable", str(warm_commands.python))
    monkeypatch.setattr(demo, "STEPS", (DemoStep("Nothing.", ("nonsense",), ""),))
    with pytest.raises(typer.Exit) as ended:
        demo.demo(yes=True)
    assert ended.value.exit_code == 1
    assert "`achse nonsense` ended with exit code 2" in capfd.readouterr().err
