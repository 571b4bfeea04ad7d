"""stubs for names of libraries in a project that is edited."""

import random
from pathlib import Path

import pytest

from achse.st.workspace import Extent, Workspace
from tests.st.workspace.sample import cold_findings

_PROJECT = """<Project><ItemGroup>
<Compile Include="MAIN.st"/><Compile Include="Other.st"/><Compile Include="GVL.st"/>
{}
</ItemGroup></Project>"""
_REFERENCE = (
    '<PlaceholderReference Include="Vendor"><DefaultResolution>Vendor, * (Somebody)'
    "</DefaultResolution><Namespace>Vendor</Namespace></PlaceholderReference>"
)
_MAIN = """PROGRAM MAIN
VAR fbDevice : FB_VendorDevice; n : INT; END_VAR
fbDevice(bEnable := TRUE, nSpeed := n);
n := fbDevice.nState;
END_PROGRAM
"""
_OTHER = """FUNCTION_BLOCK FB_Other
VAR n : INT; s : STRING; END_VAR
METHOD Count : INT
n := n + GVL.nLimit;
Count := n;
END_METHOD
END_FUNCTION_BLOCK
"""
_LISTS = "VAR_GLOBAL\n    nLimit : INT := 5;\n    fbGlobal : FB_VendorDevice;\nEND_VAR\n"


def _write(folder: Path, reference: str = _REFERENCE) -> Path:
    (folder / "MAIN.st").write_text(_MAIN)
    (folder / "Other.st").write_text(_OTHER)
    (folder / "GVL.st").write_text(_LISTS)
    project = folder / "Plc.plcproj"
    project.write_text(_PROJECT.format(reference))
    return project


def test_a_missing_library_gets_the_stand_ins_of_a_check(tmp_path: Path) -> None:
    project = _write(tmp_path)
    workspace = Workspace(project)
    assert not workspace.findings.errors
    assert workspace.findings == cold_findings(project, {})


@pytest.mark.parametrize(
    ("name", "old", "new", "extent"),
    [
        ("Other.st", "n := n + GVL.nLimit;", "n := 2;", Extent.BODIES),
        ("Other.st", "s : STRING;", "s : STRING; nMore : LREAL;", Extent.DECLARATIONS),
        ("Other.st", "n := n + GVL.nLimit;", "GVL.fbGlobal.bReset := TRUE;", Extent.PROJECT),
        ("Other.st", "Count := n;", "Count := FB_Vendor2(n);", Extent.PROJECT),
        ("MAIN.st", "n := fbDevice.nState;", "n := fbDevice.nState; n := 2;", Extent.PROJECT),
        ("MAIN.st", "fbDevice.nState", "fbDevice.sName", Extent.PROJECT),
        ("GVL.st", "nLimit : INT", "nLimit : DINT", Extent.PROJECT),
    ],
)
def test_an_edit_leaves_stand_ins_or_makes_them_again(
    tmp_path: Path, name: str, old: str, new: str, extent: Extent
) -> None:
    project = _write(tmp_path)
    workspace = Workspace(project)
    text = (tmp_path / name).read_text().replace(old, new)
    assert workspace.edit(tmp_path / name, text.encode()) is extent
    assert workspace.findings == cold_findings(project, {tmp_path / name: text})


def test_a_name_of_a_shipped_library_that_is_not_there_gets_one(tmp_path: Path) -> None:
    reference = _REFERENCE.replace("Vendor", "Tc2_Utilities")
    project = _write(tmp_path, reference)
    texts = {
        tmp_path / "MAIN.st": _MAIN.replace("FB_VendorDevice", "TON"),
        tmp_path / "GVL.st": _LISTS.replace("FB_VendorDevice", "TON"),
    }
    workspace = Workspace(project)
    for file, text in texts.items():
        workspace.edit(file, text.encode())
        assert workspace.findings == cold_findings(project, {file: text})
        workspace.close(file)
    texts[tmp_path / "Other.st"] = _OTHER.replace("Count := n;", "Count := F_GetNothingAtAll(n);")
    workspace.edit_all({file: text.encode() for file, text in texts.items()})
    assert workspace.findings == cold_findings(project, texts)
    assert not any("F_GetNothingAtAll" in one.message for one in workspace.findings.errors)


def test_drawn_edits_beside_stand_ins(tmp_path: Path) -> None:
    draw = random.Random(31)
    project = _write(tmp_path)
    firsts = {name: (tmp_path / name).read_text() for name in ("MAIN.st", "Other.st", "GVL.st")}
    words = sorted({word for text in firsts.values() for word in text.replace(";", " ").split()})
    workspace, texts = Workspace(project), {tmp_path / key: text for key, text in firsts.items()}
    for _ in range(24):
        file = draw.choice(sorted(texts))
        old = texts[file] if draw.random() < 0.5 else firsts[file.name]
        texts[file] = old.replace(draw.choice(words), draw.choice(words), 1)
        workspace.edit(file, texts[file].encode())
        assert workspace.findings == cold_findings(project, texts)
