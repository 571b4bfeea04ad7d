"""Which files a project has, and what is in one."""

import gc
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.files.files import (
    content_of,
    files_below,
    parse_file,
    project_file,
    read_sources,
    source_files,
    symbol_files,
)
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.lexis.xml import Element
from achse.st.syntax.parser import Parsed, parse
from achse.st.syntax.units import Program


def test_what_is_hidden_does_not_count(tmp_path: Path) -> None:
    for name in ("b.st", "a.st", ".git/c.st"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert [item.name for item in files_below(tmp_path)] == ["a.st", "b.st"]
    assert [name for _, name in source_files(tmp_path)] == ["a.st", "b.st"]


def test_a_folder_of_everything_is_no_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.st.files.files._MOST_ENTRIES", 20)
    for number in range(21):
        (tmp_path / f"{number}.st").touch()
    with pytest.raises(SourceError, match="expected the folder of a project: there are over 20"):
        source_files(tmp_path)


def test_the_file_that_says_what_is_in_a_project(tmp_path: Path) -> None:
    assert project_file(tmp_path) is None
    (tmp_path / "sub").mkdir()
    first = tmp_path / "sub/a.PLCPROJ"
    first.touch()
    assert project_file(tmp_path) == project_file(first) == first
    (tmp_path / "b.plcproj").touch()
    assert project_file(tmp_path) is None
    with pytest.raises(SourceError, match=r"several projects: name one of b\.plcproj, sub/a"):
        source_files(tmp_path)


def test_symbol_files_are_those_beside_it(tmp_path: Path) -> None:
    for name in ("a.st", "a.tmc", "b.TMC"):
        (tmp_path / name).touch()
    assert [item.name for item in symbol_files(tmp_path)] == ["a.tmc", "b.TMC"]
    assert [item.name for item in symbol_files(tmp_path / "a.st")] == ["a.tmc"]
    (tmp_path / "B.plcproj").touch()
    assert [item.name for item in symbol_files(tmp_path)] == ["b.TMC", "a.tmc"]


def test_what_cannot_be_read_is_reported(tmp_path: Path) -> None:
    for path in (tmp_path / "none", tmp_path, Path("a\0b")):
        with pytest.raises(SourceError, match="cannot be read"):
            content_of(path, "x")


FOLDERS = count()


@given(
    depth=st.integers(0, 5),
    solution=st.none() | st.integers(0, 5),
    kind=st.sampled_from((".sln", ".tsproj", ".TSPPROJ", ".txt")),
    up=st.integers(0, 5),
    below=st.sampled_from(("", "Shared\\", "shared/", "%53hared\\", "Shared\\Deep\\..\\")),
    link=st.sampled_from(("", "file", "folder")),
    link_level=st.integers(0, 5),
    absolute=st.booleans(),
)
def test_project_names_files_of_its_solution_only(
    tmp_path_factory: pytest.TempPathFactory,
    depth: int,
    solution: int | None,
    kind: str,
    up: int,
    below: str,
    link: str,
    link_level: int,
    absolute: bool,
) -> None:
    """`depth` folders from the root of the test to the project; levels count from that root."""
    root = tmp_path_factory.getbasetemp() / f"links{next(FOLDERS)}"
    levels = [root]
    for _ in range(depth):
        levels.append(levels[-1] / "Sub")
    project = levels[-1]
    (project / "a").mkdir(parents=True)
    up, link_level = min(up, depth), min(link_level, depth)
    if solution is not None:
        (levels[min(solution, depth)] / f"S{kind}").touch()
    named = levels[depth - up] / ("Shared" if below else "")
    (named / "Deep").mkdir(parents=True, exist_ok=True)
    target = named
    if link == "file":
        target = levels[link_level] / "elsewhere"
        target.mkdir()
        (named / "X.TcPOU").symlink_to(target / "X.TcPOU")
    elif link == "folder" and below:
        target = levels[link_level] / "elsewhere"
        (target / "Deep").mkdir(parents=True)
        (named / "Deep").rmdir()
        named.rmdir()
        named.symlink_to(target)
    (target / "X.TcPOU").touch()
    include = f"{named}/X.TcPOU" if absolute else "..\\" * up + below + "X.TcPOU"
    (project / "P.plcproj").write_text(f'<Project>\n<Compile Include="{include}"/></Project>')
    top = project
    if solution is not None and kind != ".txt" and depth - min(solution, depth) <= 3:
        top = levels[min(solution, depth)]
    if target.is_relative_to(top):
        assert [file.resolve() for file, _ in source_files(project)] == [target / "X.TcPOU"]
    else:
        with pytest.raises(SourceError, match="outside of the solution") as refusal:
            source_files(project)
        [fault] = refusal.value.faults
        assert (fault.location.path, fault.location.line) == ("P.plcproj", 2)
        assert f"expected a file in {top}, got " in fault.message
        assert str(target / "X.TcPOU") in fault.message or absolute


@given(
    names=st.lists(
        st.sampled_from(
            ("A.st", ".\\A.st", "x\\..\\A.st", "a.ST", "%41.st", "Link.st", "x\\B.st", "X/b.ST")
        ),
        min_size=1,
        max_size=20,
    )
)
def test_file_that_is_named_often_is_read_once(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    folder = tmp_path_factory.getbasetemp() / f"project{next(FOLDERS)}"
    (folder / "x").mkdir(parents=True)
    for file in ("A.st", "x/B.st"):
        (folder / file).touch()
    (folder / "Link.st").symlink_to("A.st")
    lines = [f'<Compile Include="{name}"/>' for name in names]
    (folder / "P.plcproj").write_text(f"<Project>{''.join(lines)}</Project>")
    files = [file.resolve() for file, _ in source_files(folder)]
    expected = dict.fromkeys("x/B.st" if "b" in name.lower() else "A.st" for name in names)
    assert files == [folder / name for name in expected]


def test_names_that_cannot_be_followed_are_reported(tmp_path: Path) -> None:
    (tmp_path / "ring.st").symlink_to("ring.st")
    for name in ("ring.st", "a%00.st", "none.st"):
        (tmp_path / "P.plcproj").write_text(f'<Project><Compile Include="{name}"/></Project>')
        [(file, shown)] = source_files(tmp_path)
        with pytest.raises(SourceError, match="cannot be read"):
            content_of(file, shown)


def test_elements_of_ladder_bodies_are_not_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tags: list[str] = []

    class Counted(Element):
        __slots__ = ()

        def __init__(self, tag: str, *rest: Any) -> None:
            tags.append(tag)
            super().__init__(tag, *rest)

    monkeypatch.setattr("achse.st.lexis.xml.Element", Counted)
    body = "<XmlArchive>" + "<o><v>1</v></o>" * 50 + "</XmlArchive>"
    file = tmp_path / "P.TcPOU"
    file.write_text(
        '<TcPlcObject><POU Name="P"><Declaration>PROGRAM P</Declaration>'
        f"<Implementation><NWL>{body}</NWL></Implementation>"
        '<LineIds Name="P"><LineId Id="3" Count="1" /></LineIds></POU></TcPlcObject>'
    )
    (unit,) = parse_file(file).check().units
    assert isinstance(unit, Program)
    assert isinstance(unit.body, GraphicalBody)
    assert tags == ["TcPlcObject", "POU", "Declaration", "Implementation", "NWL", "LineIds"]


def test_a_file_that_a_project_holds_is_parsed_again_only_after_a_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parsed: list[str] = []

    def noted(source: Source, **options: Any) -> Parsed:
        parsed.append(source.path)
        return parse(source, **options)

    monkeypatch.setattr("achse.st.files.files.parse", noted)
    files = [tmp_path / f"{number}.st" for number in range(3)]
    for file in files:
        file.write_text(f"{{IF defined (X)}}VAR_GLOBAL n{file.stem} : INT; END_VAR{{END_IF}}")
    first = read_sources(tmp_path, ("X",), [])[0]
    assert parsed == ["0.st", "1.st", "2.st"]
    first[0].source.library = "Lib"
    parsed.clear()
    files[1].write_text("VAR_GLOBAL m : INT; END_VAR")
    second = read_sources(tmp_path, ("X",), [])[0]
    assert parsed == ["1.st"]
    assert [one.units is other.units for one, other in zip(first, second, strict=True)] == [
        True,
        False,
        True,
    ]
    assert second[0].source is not first[0].source
    assert second[0].source.library == ""
    parsed.clear()
    read_sources(tmp_path, ("Y",), [])
    assert parsed == ["0.st", "1.st", "2.st"]  # other defines
    parsed.clear()
    del first, second
    gc.collect()
    read_sources(tmp_path, ("X",), [])
    assert parsed == ["0.st", "1.st", "2.st"]  # nothing outlives its projects


@given(st.binary(min_size=1, max_size=40), st.sampled_from([".TcPOU", ".TcGVL", ".TcDUT", ".TcIO"]))
def test_encrypted_source_is_called_so(
    tmp_path_factory: pytest.TempPathFactory, data: bytes, ending: str
) -> None:
    file = tmp_path_factory.mktemp("source") / f"A{ending}"
    file.write_bytes(b"\x01" + data)
    with pytest.raises(SourceError, match="the source is encrypted or damaged"):
        parse_file(file)


def test_file_that_the_vendors_tools_encrypted_is_called_so(tmp_path: Path) -> None:
    project, source = tmp_path / "A.plcproj", tmp_path / "A.TcPOU"
    for file in (project, source):
        file.write_bytes(b"TcEncryptedFile~s\xd5\x17dhJ\xee")
    with pytest.raises(SourceError, match=r"A\.plcproj:1:1: the file is encrypted: expected XML"):
        read_sources(project, (), [])
    with pytest.raises(SourceError, match=r"A\.TcPOU:1:1: the file is encrypted: expected XML"):
        parse_file(source)


def test_exports_count_where_there_is_nothing_else(tmp_path: Path) -> None:
    head = '<project xmlns="http://www.plcopen.org/xml/tc6_0201"/>'
    for name, text in (("a.EXP", ""), ("plc.xml", head), ("other.xml", "<a/>")):
        (tmp_path / name).write_text(text)
    assert [name for _, name in source_files(tmp_path)] == ["a.EXP", "plc.xml"]
    (tmp_path / "b.st").touch()
    assert [name for _, name in source_files(tmp_path)] == ["b.st"]
    with pytest.raises(SourceError, match=r"expected a file like \.st"):
        source_files(tmp_path / "other.xml")


def test_exports_bring_their_tasks(tmp_path: Path) -> None:
    (tmp_path / "a.EXP").write_text(
        "PROGRAM P\nEND_PROGRAM\nRESOURCE\nTASK T (INTERVAL := T#5ms);\nP();\nEND_TASK\n"
        "END_RESOURCE\n"
    )
    (tmp_path / "plc.xml").write_text(
        '<project xmlns="http://www.plcopen.org/xml/tc6_0201"><task name="U" interval="T#7ms"/>'
        "</project>"
    )
    sources, tasks = read_sources(tmp_path, (), [])
    assert [unit.name for parsed in sources for unit in parsed.units] == ["P"]
    rows = [(task.name, task.cycle_ns, task.programs) for task in tasks]
    assert rows == [("T", 5_000_000, ("P",)), ("U", 7_000_000, ())]


@pytest.mark.parametrize(
    ("cycle", "priority", "message"),
    [
        (0, 20, "expected a cycle in ns of 1 to 429496729500, got 0"),
        (999_999_999, 20, "expected a cycle in ns"),
        (10_000, 256, "expected a priority of 0 to 255, got 256"),
    ],
)
def test_task_that_cannot_be_is_a_fault(
    tmp_path: Path, cycle: int, priority: int, message: str
) -> None:
    (tmp_path / "Fast.TcTTO").write_text(
        f'<TcPlcObject><Task Name="Fast"><CycleTime>{cycle}</CycleTime>'
        f"<Priority>{priority}</Priority></Task></TcPlcObject>"
    )
    faults: list[Diagnostic] = []
    assert read_sources(tmp_path, (), faults) == ([], [])
    assert message in str(faults[0])
