"""Projects in folders."""

from pathlib import Path

from achse.lsp.projects import Projects
from tests.st.workspace.sample import FILES, write_project

_PROGRAM = "PROGRAM MAIN\nVAR n : INT; END_VAR\nn := F_Lib();\nEND_PROGRAM\n"
_LIBRARY = "FUNCTION F_Lib : INT\nF_Lib := 1;\nEND_FUNCTION\n"


def _paths(projects: Projects) -> list[Path]:
    return [one.path for one in projects]


def test_a_folder_of_sources_is_a_project(tmp_path: Path) -> None:
    projects = Projects([write_project(tmp_path)])
    projects.load()
    assert _paths(projects) == [tmp_path]
    assert projects.of(tmp_path / "Functions.st") == list(projects)
    assert not projects.findings()


def test_each_project_file_is_a_project(tmp_path: Path) -> None:
    for name in ("A", "B"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / f"{name}.st").write_text(f"FUNCTION F_{name} : INT\nx := 1;\nEND_FUNCTION\n")
        (folder / f"{name}.plcproj").write_text(
            f'<Project><ItemGroup><Compile Include="{name}.st"/></ItemGroup></Project>'
        )
    projects = Projects([tmp_path])
    assert _paths(projects) == []
    (project,) = projects.of(tmp_path / "B" / "B.st")
    assert project.path == tmp_path / "B" / "B.plcproj"
    projects.load()
    assert set(projects.findings()) == {tmp_path / "A" / "A.st", tmp_path / "B" / "B.st"}


def test_a_station_names_sources_and_libraries(tmp_path: Path) -> None:
    for name, text in {"plc/Main.st": _PROGRAM, "lib/Lib.st": _LIBRARY}.items():
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text(text)
    station = '[[plc]]\nsources = "plc"\nlibraries = ["lib"]\n'
    (tmp_path / "station.toml").write_text(station)
    projects = Projects([tmp_path])
    (project,) = projects.of(tmp_path / "plc" / "Main.st")
    assert not project.findings.errors
    (tmp_path / "station.toml").write_text("[[plc]\n")
    assert Projects([tmp_path]).of(tmp_path / "plc" / "Main.st")[0].path == tmp_path


def test_a_file_outside_of_all_folders_is_its_own_project(tmp_path: Path) -> None:
    file = tmp_path / "Main.st"
    file.write_text(_PROGRAM)
    projects = Projects()
    projects.edit({file: _PROGRAM.replace("F_Lib()", "2").encode()})
    assert _paths(projects) == [file]
    assert not projects.findings()
    projects.of(file)[0].close(file)
    assert set(projects.findings()) == {file}
    projects.close(file)
    assert _paths(projects) == []
    assert projects.of(tmp_path / "notes.txt") == []


def test_a_file_that_no_project_names_is_one_while_it_is_open(tmp_path: Path) -> None:
    (tmp_path / "Plc.plcproj").write_text(
        '<Project><ItemGroup><Compile Include="a.st"/></ItemGroup></Project>'
    )
    (tmp_path / "a.st").write_text("PROGRAM MAIN\nEND_PROGRAM\n")
    spare = tmp_path / "b.st"
    spare.write_text("FUNCTION F : T_Nothing\nEND_FUNCTION\n")
    projects = Projects([tmp_path])
    projects.edit({spare: spare.read_bytes()})
    assert spare in projects.findings()
    projects.close(spare)
    assert not projects.findings()
    assert [one.path.name for one in projects] == ["Plc.plcproj"]


def test_open_texts_count_in_projects_that_are_loaded_later(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    projects = Projects([folder])
    name = "GVLs/GVL.TcGVL"
    projects.edit({folder / name: FILES[name].replace("cMost", "cLeast").encode()})
    assert projects.findings()
    projects.reread([folder / name])
    assert projects.findings()
