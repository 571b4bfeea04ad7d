"""Options of tasks and links of axes in the solution's project."""

from pathlib import Path

import pytest

from achse.st.files import solution
from achse.st.files.solution import (
    AxisMapping,
    ChannelMapping,
    TaskOptions,
    mapping_files,
    nc_mappings,
    solution_files,
    solutions_of,
    task_options,
    type_files,
)
from achse.st.project import load_project

FILE = b"""<?xml version="1.0"?>
<TcSmProject><Project><System><Tasks>
<Task Id="3" Priority="20" CycleTime="100000" AmsPort="355" AdtTasks="true" ExceedWarning="4">
  <Name>PlcTask</Name></Task>
<Task Id="4" AmsPort="99999999" ExceedWarning="999999999" DisableFpExceptions="true">
  <Name> A &amp; B </Name></Task>
<Task Id="5" AmsPort="x"><Name>plctask</Name></Task>
</Tasks></System></Project></TcSmProject>
"""
TASK = b"""<?xml version="1.0"?><TcPlcObject><Task Name="PlcTask"><CycleTime>5000</CycleTime>
<Priority>7</Priority><PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>"""


def test_options_by_name() -> None:
    assert task_options([(FILE, "a.tsproj")]) == {
        "plctask": TaskOptions(4, 355),
        "a & b": TaskOptions(1_000_000, 0, False),
    }


@pytest.mark.parametrize(
    "data", [b"", b"<Task", b"<Task><Name>", b"\xff\xfe<Task ><Name>\xff</Name>"]
)
def test_what_is_not_well_formed_says_nothing_of_ports(data: bytes) -> None:
    assert all(options == TaskOptions() for options in task_options([(data, "a")]).values())


def test_a_project_takes_the_options_of_its_solution(tmp_path: Path) -> None:
    (tmp_path / "Machine.tsproj").write_bytes(FILE)
    folder = tmp_path / "Plc"
    folder.mkdir()
    (folder / "MAIN.st").write_text("PROGRAM MAIN END_PROGRAM")
    (folder / "PlcTask.TcTTO").write_bytes(TASK)
    (task,) = load_project(folder).tasks
    assert (task.name, task.cycle_ns, task.priority) == ("PlcTask", 5_000_000, 7)
    assert (task.watchdog_cycles, task.port) == (4, 355)


LINKS = b"""<TcSmProject><Project><Motion><NC><SAF><Axis Id="1" AxisType="1"><Name>Axis 1</Name>
<AxisPara/></Axis><Axis File="A &amp; B.xti" Id="7"/><Axis Id="x"><Name>Odd</Name></Axis>
</SAF></NC></Motion></Project><Mappings>
<OwnerA Name="TIID^Device 1"><OwnerB Name="TIRC^TcCOM"><Link VarA="a^b" VarB="c^d"/>
</OwnerB></OwnerA>
<OwnerA Name="TIPC^Plc^Plc Instance">
<OwnerB Name="TINC^NC-Task 1 SAF^Axes^Axis 1">
<Link VarA="PlcTask Inputs^MAIN.a.NcToPlc" VarB="Outputs^ToPlc"/>
<Link VarA="PlcTask Outputs^MAIN.a.PlcToNc" VarB="Inputs^FromPlc"/>
<Link VarA="PlcTask Outputs^MAIN.a.PlcToNc^Override" VarB="Inputs^FromPlc"/></OwnerB>
<OwnerB Name="TINC^NC-Task 1 SAF^Axes^Axis 1^Enc"><Link VarA="b^c" VarB="Outputs^ToPlc"/></OwnerB>
</OwnerA>
<OwnerA Name="TINC^NC-Task 1 SAF^Axes^A &amp; B"><OwnerB Name="TIPC^Plc^Plc Instance">
<Link VarB="PlcTask Inputs^GVL.b[2]" VarA="Outputs^ToPlc" Size="8"/></OwnerB>
<OwnerB Name="TIPC"><Link VarB="x^GVL.c" VarA="Outputs^ToPlc"/></OwnerB></OwnerA>
</Mappings></TcSmProject>"""


def test_links_of_axes_from_both_sides() -> None:
    """Whole structures of axes only, whichever side stands first."""
    assert nc_mappings([(LINKS, "a.tsproj")]).axes == (
        AxisMapping("Axis 1", 1, "Plc", "MAIN.a.NcToPlc"),
        AxisMapping("Axis 1", 1, "Plc", "MAIN.a.PlcToNc"),
        AxisMapping("A & B", 7, "Plc", "GVL.b[2]"),
    )


def test_links_in_files_of_their_own(tmp_path: Path) -> None:
    """A PLC's file has its links; ids of axes are in that of the NC."""
    part = b'<Mappings><OwnerA Name="%s"><OwnerB Name="TINC^SAF^%s">%s</OwnerB></OwnerA></Mappings>'
    link = b'<Link VarA="PlcTask Inputs^MAIN.%s" VarB="Outputs^ToPlc"/>'
    (tmp_path / "M.tsproj").write_bytes(part % (b"TIPC^A^A Instance", b"Channel", link % b"c"))
    for names, data in (
        ("PLC/B.xti", part % (b"B Instance", b"Axes^X", link % b"x")),
        ("PLC/C Instance.xti", part % (b"", b"Kin", link % b"k")),
        ("PLC/D.xti", part % (b"D", b"Kin", link % b"k")),
        ("PLC/E.txt", part % (b"E Instance", b"Kin", link % b"k")),
        ("NC/NC.xti", b'<Axis File="X.xti" Id="9"/>'),
    ):
        file = tmp_path / "_Config" / names
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    mappings = nc_mappings(mapping_files(solutions_of(tmp_path)))
    assert mappings.axes == (AxisMapping("X", 9, "B", "MAIN.x"),)
    assert mappings.channels == (
        ChannelMapping("Channel", "A", "MAIN.c"),
        ChannelMapping("Kin", "C", "MAIN.k"),
    )
    assert mappings.of_projects({"c"}) == (mappings.axes, mappings.channels[1:])


_PART = (
    b'<Mappings><OwnerA Name="P%d Instance"><OwnerB Name="TINC^SAF^Axes^A%d">'
    b'<Link VarA="PlcTask Inputs^MAIN.x" VarB="Outputs^ToPlc"/></OwnerB></OwnerA></Mappings>'
)


def many_items(folder: Path, count: int) -> Path:
    """A solution with so many files of PLCs, each with one link."""
    plcs = folder / "_Config" / "PLC"
    plcs.mkdir(parents=True)
    (folder / "M.tsproj").write_bytes(b"")
    for n in range(count):
        (plcs / f"P{n:03d}.xti").write_bytes(_PART % (n, n))
    return folder


def test_every_file_of_a_solution_is_read(tmp_path: Path) -> None:
    solutions = solutions_of(many_items(tmp_path, 250))
    axes = nc_mappings(mapping_files(solutions)).axes
    assert [(each.axis, each.plc) for each in axes] == [(f"A{n}", f"P{n}") for n in range(250)]


def test_files_beyond_the_bound_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    solutions = solutions_of(many_items(tmp_path, 12))
    monkeypatch.setattr(solution, "_MOST_BYTES", 5 * len(_PART % (1, 1)))
    assert len(nc_mappings(mapping_files(solutions)).axes) == 5
    assert "links of 7 of 12 files are left out, from P005.xti on" in caplog.text


@pytest.mark.parametrize("part", [b"<Mappings>", b"<Mappings></Mappings", b"<Link ", b"<Axis "])
def test_repeated_parts_take_linear_time(part: bytes) -> None:
    data = b"<Mappings>" + part * 200_000 + b"</Mappings>"
    assert nc_mappings([(data, "a.tsproj")]) == ((), ())


@pytest.mark.parametrize(
    "data",
    [b"", b"<Mappings></Mappings>", b"<Mappings><Link/></Mappings>", b"<Mappings><OwnerA><OwnerB>"
     b'<Link VarA="" VarB="Outputs^ToPlc"/></Mappings>', b"<Mappings>\xff<OwnerA Name=\"\xff\">"],
)  # fmt: skip
def test_no_links(data: bytes) -> None:
    assert nc_mappings([(data, "a.tsproj")]) == ((), ())


def test_the_solution_is_in_the_folder_or_above(tmp_path: Path) -> None:
    folder = tmp_path / "a/b"
    folder.mkdir(parents=True)
    (tmp_path / "M.tsproj").write_bytes(LINKS)
    (tmp_path / "a" / "N.TSPROJ").write_bytes(b"")
    assert list(solution_files(folder)) == [(b"", "N.TSPROJ"), (LINKS, "M.tsproj")]


TYPES = b"""<TcSmProject><DataTypes><DataType><Name PersistentType="true">E_Kind</Name>
<BitSize>16</BitSize><BaseType>INT</BaseType><EnumInfo><Text>FIRST</Text><Enum>3</Enum></EnumInfo>
</DataType></DataTypes><Project><System><TypeSystem>
<AdditionalTmcFile Name="More" File="Types\\More.tmc"/><AdditionalTmcFile File="Lost.tmc"/>
</TypeSystem></System></Project></TcSmProject>"""
MORE = TYPES.replace(b"TcSmProject", b"TcModuleClass").replace(b"E_Kind", b"E_More")


def test_a_project_has_the_types_of_its_solution(tmp_path: Path) -> None:
    (tmp_path / "Machine.tsproj").write_bytes(TYPES)
    (tmp_path / "Types").mkdir()
    (tmp_path / "Types" / "More.tmc").write_bytes(MORE)
    folder = tmp_path / "Plc"
    folder.mkdir()
    assert [name for _, name in type_files(folder)] == ["More.tmc"]
    (folder / "MAIN.st").write_text(
        "PROGRAM MAIN VAR a : E_Kind := E_Kind.FIRST; b : E_More := E_More.FIRST; END_VAR"
        " END_PROGRAM"
    )
    main = load_project(folder).declarations.programs["main"].__iec__
    assert [main.member(name).initial for name in ("a", "b")] == [3, 3]
