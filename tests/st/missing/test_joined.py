"""Missing names that have one type, and programs whose library is taken away."""

import random
from pathlib import Path

import pytest

from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.st.check import check
from achse.st.missing.joined import join_uses
from achse.st.missing.uses import MissingUse
from achse.st.project import examine_project

VALUES = {
    "BOOL": "TRUE",
    "INT": "{0}",
    "DINT": "{0}00000",
    "LREAL": "{0}.5",
    "STRING(30)": "'{0}'",
    "TIME": "T#{0}s",
}


def _stubs(folder: Path, text: str) -> str:
    """Check and run a program whose library is not here; return its stubs."""
    (folder / "a.st").write_text(text)
    (folder / "a.plcproj").write_text(
        '<P><Compile Include="a.st"/><LibraryReference Include="Lib,*,v"/></P>'
    )
    project, error = examine_project(folder)
    assert error is None, f"{error}\n{text}"
    checked = check(project.declarations)
    stubs = "\n".join(project.stubs.values())
    assert checked.faults == (), f"{checked.faults}\n{text}\n{stubs}"
    main = project.declarations.programs["p"]
    task = Task("T", 1_000_000, [main])
    plc = PlcRuntime([task], project.declarations.units, bodies=Bodies(checked))
    for cycle in range(1, 4):
        plc.run_due(cycle * 1_000_000)
    assert (plc.failure, task.cycle_count) == ("", 3)
    return stubs


def test_parts_of_assigned_names_have_one_type() -> None:
    use, other = MissingUse("ST_A").member("stA"), MissingUse("ST_B").member("stB")
    use.member("x").note_type("LREAL")
    other.member("y").note_type("BOOL")
    use.peers.append(other)
    other.peers.append(use)
    first, second = MissingUse("ST_A", members={"sta": use}), MissingUse("ST_B")
    second.members["stb"] = other
    types = {"st_a": first, "st_b": second}
    assert join_uses(types, {}, lambda name: False)
    assert use.members is other.members
    assert sorted(use.members) == ["x", "y"]
    assert use.kind == other.kind or not other.kind


def test_a_declared_type_stands_for_the_parts() -> None:
    owner = MissingUse("ST_A")
    use = owner.member("stOwn")
    use.member("x")
    use.note_type("ST_Own")
    assert join_uses({"st_a": owner}, {}, lambda name: name == "ST_Own")
    assert (use.type, use.members) == ("ST_Own", {})


@pytest.mark.parametrize(
    ("uses", "stub"),
    [
        ("VAR a : ST_A; b : ST_B; END_VAR a.t := b.t; a.t.x := 1.5; b.t.y := TRUE;", "x : LREAL"),
        ("VAR a : ST_Many; n : INT; END_VAR a.n[n, 1] := 3;", "ARRAY [0..31, 0..31]"),
        ("VAR a : ST_A; s : STRING; END_VAR s := CONCAT('a', a.Name);", "Name : STRING(255)"),
        ("VAR a : T_Text; END_VAR a := 'text';", "TYPE T_Text : STRING(255)"),
        ("VAR o : FB_Own; END_VAR o.Take(cNames.First);", "First : STRING(30)"),
        ("VAR o : FB_Own; END_VAR o.Take(sText := cNames.First);", "First : STRING(30)"),
        ("VAR b : BOOL; END_VAR b := gFirstScan;", "gFirstScan : BOOL"),
        ("VAR s : ST_Own; END_VAR s := gThing; gThing.x := 1;", "gThing : ST_Own"),
        ("VAR n : INT; END_VAR n := MODE_HAND_RUN;", "MODE_HAND_RUN : INT"),
        ("VAR n : INT; END_VAR n := Shared; END_PROGRAM PROGRAM Q Shared := 2;", "Shared : INT"),
        ("VAR r : LREAL; END_VAR gAxes[1].Data.Speed := r;", "Speed : LREAL"),
    ],
)
def test_uses_show_types_and_lists(tmp_path: Path, uses: str, stub: str) -> None:
    own = "TYPE ST_Own : STRUCT x : INT; END_STRUCT END_TYPE "
    own += "FUNCTION_BLOCK FB_Own METHOD Take VAR_INPUT sText : STRING(30); END_VAR END_METHOD"
    assert stub in _stubs(tmp_path, f"PROGRAM P {uses} END_PROGRAM {own} END_FUNCTION_BLOCK")


def test_library_in_front_of_a_function_is_no_part_of_a_missing_base(tmp_path: Path) -> None:
    text = "FUNCTION_BLOCK FB_T EXTENDS Lib.FB_Suite METHOD Run Lib.TEST('a'); END_METHOD "
    text += "END_FUNCTION_BLOCK PROGRAM P VAR t : FB_T; END_VAR t.Run(); END_PROGRAM"
    assert "Lib :" not in _stubs(tmp_path, text)


def test_variable_that_one_program_alone_uses_is_no_list_variable(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM P VAR n : INT; END_VAR n := Missing; END_PROGRAM")
    (tmp_path / "a.plcproj").write_text(
        '<P><Compile Include="a.st"/><LibraryReference Include="Lib,*,v"/></P>'
    )
    project, _ = examine_project(tmp_path)
    assert project.stubs == {}


@pytest.mark.parametrize("seed", range(12))
def test_program_runs_when_its_library_is_taken_away(tmp_path: Path, seed: int) -> None:
    """Draw structures, lists, blocks and functions of a library, and uses of them alone."""
    draw = random.Random(seed)
    lines: list[str] = []
    declared: list[str] = []
    for number in range(draw.randint(2, 5)):
        type = draw.choice(list(VALUES))
        value = VALUES[type].format(draw.randint(1, 9))
        declared.append(f"v{number} : {type};")
        lines += [f"v{number} := {value};"]
        for step in range(draw.randint(1, 4)):
            name = f"{number}{step}"
            match draw.randrange(7):
                case 0:  # a structure, and one inside
                    declared.append(f"s{name} : ST_Part{number};")
                    lines += [f"s{name}.Inner.Value{number} := v{number};"]
                    lines += [f"v{number} := s{name}.Inner.Value{number};"]
                case 1:  # two structures with one type inside
                    declared.append(f"a{name} : ST_Left{number}; b{name} : ST_Right{number};")
                    lines += [f"a{name}.Both := b{name}.Both;"]
                    lines += [f"b{name}.Both.Value{number} := v{number};"]
                case 2:  # a list, whose constant stands behind it or alone
                    lines += [f"v{number} := GVL_Lib.Value{number};"]
                case 3:
                    lines += [
                        f"IF LIB_VALUE_{number} = v{number} THEN v{number} := {value}; END_IF"
                    ]
                case 4:  # a block with inputs, outputs and a method
                    declared.append(f"f{name} : FB_Part{number};")
                    lines += [f"f{name}(In{number} := v{number}, Out{number} => v{number});"]
                    lines += [f"v{number} := f{name}.Read{number}(TRUE);"]
                case 5:  # an array of a structure
                    declared.append(f"m{name} : ST_Row{number};")
                    lines += [f"m{name}.Rows[{draw.randint(0, 9)}].Cell{number} := v{number};"]
                case _:
                    lines += [f"v{number} := F_Lib{number}({draw.randint(1, 9)}, v{number});"]
    draw.shuffle(lines)
    body = "\n".join(lines)
    variables = "\n".join(declared)
    _stubs(tmp_path, f"PROGRAM P\nVAR\n{variables}\nEND_VAR\n{body}\nEND_PROGRAM")
