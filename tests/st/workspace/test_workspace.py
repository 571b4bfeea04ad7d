"""Findings after edits, compared with those of a check from nothing."""

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.st.lint.options import LintOptions
from achse.st.workspace import Extent, Workspace
from tests.st.workspace.declared_edits import EditedProject
from tests.st.workspace.sample import (
    FILES,
    Edit,
    cold_findings,
    cold_lint,
    edited,
    edits,
    write_project,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_project(tmp_path_factory.mktemp("project"))


@settings(deadline=None, max_examples=12)
@given(edits=edits(), check_all=st.booleans())
def test_any_edits_have_the_findings_of_a_cold_check(
    folder: Path, edits: list[Edit], check_all: bool
) -> None:
    workspace = Workspace(folder, check_all=check_all)
    texts: dict[Path, str] = {}
    for edit in edits:
        file = folder / edit.file
        texts[file] = edited(texts.get(file, FILES[edit.file]), edit)
        workspace.edit(file, texts[file].encode())
        assert workspace.findings == cold_findings(folder, texts, check_all=check_all)
    for file in texts:
        workspace.close(file)
    assert workspace.findings == cold_findings(folder, {}, check_all=check_all)


def _all_rules(project: Path) -> LintOptions:
    return LintOptions().with_all()


def test_edits_of_declarations_have_the_findings_of_a_cold_check(
    tmp_path: Path, many: Callable[[int], int]
) -> None:
    generator = random.Random(31)
    count = 36 if many(1) == 1 else 1_000
    project, workspace, extents = None, None, Counter[Extent]()
    for number in range(count):
        if project is None or workspace is None or number % 100 == 0:
            project = EditedProject(tmp_path / str(number), generator)
            workspace = Workspace(project.folder, lint_rules=_all_rules)
        if generator.random() < 0.05:
            for file in project.move_a_file():
                extents[workspace.reread(file)] += 1
                if file in project.texts:
                    workspace.edit(file, project.texts[file].encode())
                else:
                    workspace.close(file)
        else:
            file = project.edit()
            extents[workspace.edit(file, project.texts[file].encode())] += 1
        assert workspace.findings == cold_findings(project.folder, project.texts), number
        if number % 6 == 0:
            assert list(workspace.lint()) == cold_lint(project.folder, project.texts), number
    assert extents[Extent.DECLARATIONS] > count / 3
    assert extents[Extent.PROJECT] < count / 6


def test_an_edit_checks_what_names_the_changed_unit(tmp_path: Path) -> None:
    texts = {
        "Base.st": "TYPE ST_Base : STRUCT n : INT; END_STRUCT END_TYPE",
        "Holder.st": "TYPE ST_Holder : STRUCT inner : ST_Base; END_STRUCT END_TYPE",
        "Main.st": "PROGRAM MAIN\nVAR held : ST_Holder; s : STRING; END_VAR\n"
        "s := held.inner.n;\nEND_PROGRAM\n",
        "Other.st": "PROGRAM OTHER\nVAR n : INT; END_VAR\nn := 'text';\nEND_PROGRAM\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    workspace = Workspace(tmp_path)
    assert len(workspace.findings.errors) == 2
    content = texts["Base.st"].replace("INT", "STRING").encode()
    assert workspace.edit(tmp_path / "Base.st", content) is Extent.DECLARATIONS
    assert [one.location.path for one in workspace.findings.errors] == ["Other.st"]
    assert workspace.close(tmp_path / "Base.st") is Extent.DECLARATIONS
    assert len(workspace.findings.errors) == 2


def test_a_chain_of_declarations_that_becomes_too_deep_is_found(tmp_path: Path) -> None:
    for number in range(63):
        following = f"T{number + 1}" if number < 62 else "INT"
        (tmp_path / f"T{number}.st").write_text(f"TYPE T{number} : {following}; END_TYPE")
    workspace = Workspace(tmp_path)
    assert not workspace.findings.errors
    last = tmp_path / "T62.st"
    text = "TYPE T62 : A; END_TYPE TYPE A : B; END_TYPE TYPE B : C; END_TYPE TYPE C : INT; END_TYPE"
    workspace.edit(last, text.encode())
    assert workspace.findings == cold_findings(tmp_path, {last: text})
    assert workspace.findings.errors
    new = tmp_path / "T0.st"
    workspace.edit(new, b"TYPE T0 : INT; END_TYPE")
    assert workspace.findings == cold_findings(
        tmp_path, {last: text, new: "TYPE T0 : INT; END_TYPE"}
    )


def _changed(name: str, before: str, after: str) -> bytes:
    assert before in FILES[name]
    return FILES[name].replace(before, after).encode()


@pytest.mark.parametrize(
    ("name", "before", "after", "extent"),
    [
        ("POUs/MAIN.TcPOU", "nSum := 0;", "nSum := 'a';", Extent.BODIES),
        ("POUs/MAIN.TcPOU", "nSum := 0;", "nSum := 0; (* new *)", Extent.BODIES),
        ("POUs/FB_Drive.TcPOU", "Position := nPosition;", "", Extent.BODIES),
        ("Functions.st", "F_Add := a + b;", "\nF_Add := a + c;", Extent.BODIES),
        ("POUs/MAIN.TcPOU", "nSum : DINT;", "nSum : LREAL;", Extent.DECLARATIONS),
        ("DUTs/E_State.TcDUT", "Moving", "Running", Extent.DECLARATIONS),
        ("Functions.st", "FB_Spare", "TON", Extent.PROJECT),
        ("GVLs/GVL.TcGVL", "]]>", "", Extent.FILES),
        ("GVLs/GVL.TcGVL", "nCount", "nCount", Extent.NOTHING),
        ("Task.TcTTO", "MAIN", "OTHER", Extent.FILES),
    ],
)
def test_an_edit_reaches_as_far_as_it_changes_declarations(
    folder: Path, name: str, before: str, after: str, extent: Extent
) -> None:
    workspace = Workspace(folder)
    content = _changed(name, before, after)
    assert workspace.edit(folder / name, content) is extent
    assert workspace.edit(folder / name, content) is Extent.NOTHING
    assert workspace.findings == cold_findings(folder, {folder / name: content.decode()})


def test_findings_move_with_the_lines_above_them(folder: Path) -> None:
    workspace = Workspace(folder)
    name = "POUs/MAIN.TcPOU"
    faulty = FILES[name].replace("nOld := nSum;", "nOld := nothing;")
    workspace.edit(folder / name, faulty.encode())
    (first,) = workspace.findings.errors
    longer = faulty.replace("fbFast.Move", "\n\n\nfbFast.Move")
    assert workspace.edit(folder / name, longer.encode()) is Extent.BODIES
    (second,) = workspace.findings.errors
    assert second.location.line == first.location.line + 3
    assert second.message == first.message


def test_a_library_that_changes_is_read_again(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    library = tmp_path / "lib" / "Lib.st"
    library.write_text("FUNCTION F_Lib : INT\nF_Lib := 1;\nEND_FUNCTION\n")
    main = tmp_path / "Main.st"
    main.write_text("PROGRAM MAIN\nVAR n : INT; END_VAR\nn := F_Lib();\nEND_PROGRAM\n")
    workspace = Workspace(main, libraries=[tmp_path / "lib"])
    assert not workspace.findings.errors
    assert workspace.edit(library, b"FUNCTION F_Other : INT\nEND_FUNCTION\n") is Extent.FILES
    assert "F_Lib" in workspace.findings.errors[0].message


def test_files_come_and_go(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    workspace = Workspace(folder)
    assert not workspace.findings.errors
    (folder / "DUTs" / "E_State.TcDUT").unlink()
    assert workspace.reread(folder / "DUTs" / "E_State.TcDUT") is Extent.PROJECT
    assert workspace.findings == cold_findings(folder, {})
    assert workspace.findings.errors
    (folder / "More.st").write_text("TYPE E_State : (Idle, Moving, Failed); END_TYPE")
    assert workspace.reread(folder / "More.st") is Extent.DECLARATIONS
    assert workspace.reread(folder / "More.st") is Extent.NOTHING
    assert not workspace.findings.errors
    (folder / "Other.TcTTO").write_text(FILES["Task.TcTTO"].replace("PlcTask", "Other"))
    assert workspace.reread(folder / "Other.TcTTO") is Extent.FILES
    assert workspace.findings == cold_findings(folder, {})


def test_a_project_file_names_files_that_come_and_go(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    lines = [f'<Compile Include="{name}" />' for name in FILES if name != "Functions.st"]
    project = folder / "Plc.plcproj"

    def listing(*more: str) -> None:
        project.write_text(f"<Project><ItemGroup>{''.join([*lines, *more])}</ItemGroup></Project>")

    listing()
    workspace = Workspace(folder)
    assert workspace.findings.errors
    listing('<Compile Include="Functions.st"><SubType>Code</SubType></Compile>\n')
    assert workspace.reread(project) is Extent.DECLARATIONS
    assert workspace.findings == cold_findings(folder, {})
    assert not workspace.findings.errors
    listing('<Compile Include="Functions.st" />', "<Version>2</Version>")
    assert workspace.reread(project) is Extent.FILES


_COMING = (
    *("TYPE E_State : (Idle, Moving, Failed := 3); END_TYPE", "VAR_GLOBAL\n n : INT;\nEND_VAR"),
    *("FUNCTION F_Add : DINT\nVAR_INPUT a, b, c : DINT; END_VAR\nEND_FUNCTION", "PROGRAM P\n"),
    *("FUNCTION_BLOCK TON\nEND_FUNCTION_BLOCK", "FUNCTION F : INT\nF := GVL.nCount;\nEND_FUNCTION"),
    *(
        "",
        "TYPE ST_New : STRUCT e : E_State; b : FB_Drive; END_STRUCT END_TYPE",
        "GVL.nCount := 1;",
    ),
    *("FUNCTION_BLOCK FB_New EXTENDS FB_Fast\nEND_FUNCTION_BLOCK\n", "NAMESPACE N\nEND_NAMESPACE"),
)


@settings(deadline=None, max_examples=5)
@given(st.randoms(use_true_random=False))
def test_any_files_that_come_and_go_have_the_findings_of_a_cold_check(
    tmp_path_factory: pytest.TempPathFactory, random: random.Random
) -> None:
    folder = write_project(tmp_path_factory.mktemp("files"))
    workspace = Workspace(folder)
    names = [name for name in FILES if name != "POUs/MAIN.TcPOU"]
    for _ in range(random.randint(1, 4)):
        changed = random.sample(
            [*names, "New.st", "DUTs/A.st", "Z.st", "GVL.st"], random.randint(1, 3)
        )
        for name in changed:
            if not (folder / name).exists():
                (folder / name).write_text(FILES.get(name) or random.choice(_COMING), "utf-8")
            elif random.random() < 0.3 and not (folder / "Moved.st").exists():
                (folder / name).rename(folder / "Moved.st")
            else:
                (folder / name).unlink()
        if random.random() < 0.5:
            workspace.relist()
        else:
            for name in (*changed, "Moved.st"):
                workspace.reread(folder / name)
        assert workspace.findings == cold_findings(folder, {})


def test_a_folder_without_sources_is_a_finding(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "nothing")
    assert "expected a folder" in workspace.findings.errors[0].message
    assert workspace.sources == ()
    assert workspace.edit(tmp_path / "x.txt", b"text") is Extent.NOTHING
