"""A PLC project whose sources pages edit, and the station that runs it."""

from pathlib import Path

from achse.station import Station
from achse.web.settings import EditedProject, WebSettings

__all__ = ["MAIN", "make_project", "settings", "station"]

MAIN = "PROGRAM MAIN\nVAR\n    nCount : DINT;\nEND_VAR\nnCount := nCount + 1;\nEND_PROGRAM\n"
POU = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject><POU Name="F_Twice"><Declaration><![CDATA[FUNCTION F_Twice : INT
VAR_INPUT
    n : INT;
END_VAR]]></Declaration>
<Implementation><ST><![CDATA[F_Twice := 2 * n;]]></ST></Implementation></POU></TcPlcObject>
"""


def make_project(folder: Path) -> Path:
    """A folder of sources beside a station.toml."""
    project = folder / "plc"
    project.mkdir()
    (project / "MAIN.st").write_text(MAIN)
    (project / "F_Twice.TcPOU").write_text(POU)
    (project / "notes.txt").write_text("no source")
    (folder / "station.toml").write_text('[[plc]]\nsources = "plc"\n')
    return project


def settings(project: Path, read_only: bool = False) -> WebSettings:
    projects = (EditedProject("plc (851)", project),)
    return WebSettings(read_only=read_only, projects=projects)


def station(project: Path) -> Station:
    return Station.load(project.parent / "station.toml")
