"""Where TcUnit is looked for, and what is said if it is nowhere."""

import shutil
from pathlib import Path

import pytest

from achse.tcunit.locate import VARIABLE, TcUnitMissing, find_tcunit, has_tcunit, units_of


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "solution" / "plant" / "plc"
    folder.mkdir(parents=True)
    (folder / "main.st").write_text("PROGRAM MAIN\nEND_PROGRAM\n")
    return folder


def test_a_library_that_is_named(project: Path, tcunit_stub: Path) -> None:
    assert find_tcunit(project, [project, tcunit_stub], {}) == tcunit_stub
    assert (
        find_tcunit(project / "main.st", [tcunit_stub / "suite.st"], {}) == tcunit_stub / "suite.st"
    )


def test_the_environment_variable(project: Path, tcunit_stub: Path) -> None:
    assert find_tcunit(project, environ={VARIABLE: str(tcunit_stub)}) == tcunit_stub
    with pytest.raises(TcUnitMissing, match=f"{VARIABLE}=.*has no function block FB_TestSuite"):
        find_tcunit(project, environ={VARIABLE: str(project)})
    with pytest.raises(TcUnitMissing, match="nowhere"):
        find_tcunit(project, environ={VARIABLE: "nowhere"})


@pytest.mark.parametrize("home", ["TcUnit", "lib", "../_Libraries", "../libraries/tcunit"])
def test_a_folder_beside_the_project(project: Path, tcunit_stub: Path, home: str) -> None:
    target = (project.parent / home).resolve()
    shutil.copytree(tcunit_stub, target)
    path = find_tcunit(project, environ={})
    assert path is not None
    assert path.is_relative_to(project.parents[1])
    assert has_tcunit(path)


def test_of_several_projects_in_a_folder_the_one_named_tcunit(
    project: Path, tcunit_stub: Path
) -> None:
    home = project.parent / "lib"
    shutil.copytree(tcunit_stub, home / "TcUnit")
    for name in ("TcUnit", "Other"):
        (home / name).mkdir(exist_ok=True)
        (home / name / f"{name}.plcproj").write_text(
            '<Project><ItemGroup><Compile Include="suite.st"/></ItemGroup></Project>'
        )
    assert find_tcunit(project, environ={}) == home / "TcUnit" / "TcUnit.plcproj"
    assert find_tcunit(project, [home], {}) == home / "TcUnit" / "TcUnit.plcproj"


def test_a_project_that_has_it_itself(project: Path, tcunit_stub: Path) -> None:
    assert find_tcunit(tcunit_stub, environ={}) is None
    shutil.copytree(tcunit_stub, project / "lib")
    assert find_tcunit(project, environ={}) is None


def test_nowhere_says_what_to_get(project: Path) -> None:
    with pytest.raises(TcUnitMissing) as missing:
        find_tcunit(project, environ={})
    for word in ("github.com/tcunit/TcUnit", "--library", "station.toml", VARIABLE):
        assert word in str(missing.value)


def test_names_of_its_units(tcunit_stub: Path) -> None:
    names = units_of(tcunit_stub)
    assert {"fb_testsuite", "test", "test_finished", "run", "i_assertmessageformatter"} <= names


def test_files_that_cannot_be_read_are_passed_over(project: Path) -> None:
    (project / "broken.st").symlink_to(project / "nothing.st")
    assert not has_tcunit(project)
    assert not has_tcunit(project / "nothing")
