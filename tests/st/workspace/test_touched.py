"""Names by which an edit reaches units and routines."""

from pathlib import Path

from achse.st.workspace import Workspace
from achse.st.workspace.touched import Touched, WordIndex, first_touched, routines_again


def _touched(workspace: Workspace, units: set[str], words: set[str]) -> Touched:
    checking = workspace.checking
    assert checking is not None
    entries = [one for one in checking.names.scopes.entries.values() if not one.is_library]
    return WordIndex().touched(workspace.sources, entries, Touched(units, words))


def test_units_are_touched_by_names_in_their_declarations(workspace: Workspace) -> None:
    units, words = _touched(workspace, {"fb_drive"}, {"fb_drive"})
    assert units == {"fb_drive", "fb_fast", "gvl", "main", "st_data"}
    assert {"ncount", "fbspare", "cmost"} <= words


def test_a_name_in_a_body_touches_no_unit(workspace: Workspace) -> None:
    assert _touched(workspace, {"f_add"}, {"f_add"}).units == {"f_add"}


def test_values_of_enumerations_need_no_prefix(workspace: Workspace) -> None:
    units, words = _touched(workspace, {"e_state"}, {"e_state", "idle"})
    assert units == {"e_state", "main"}
    assert "moving" not in words


def test_routines_that_name_a_touched_unit_are_checked_again(workspace: Workspace) -> None:
    checking = workspace.checking
    assert checking is not None
    main = workspace.source_of(workspace.path / "POUs" / "MAIN.TcPOU")
    assert main is not None
    found = routines_again(checking, Touched({"f_add"}, {"f_add"}), {main}, WordIndex())
    assert {one.key for one in found} == {"main"}
    assert not routines_again(checking, Touched({"main"}, {"main"}), {main}, WordIndex())


def test_a_name_of_a_library_touches_everything(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("TYPE T_Own : INT; END_TYPE")
    (tmp_path / "b.st").write_text("FUNCTION F : INT\nEND_FUNCTION")
    first, other = Workspace(tmp_path), Workspace(tmp_path)
    file = tmp_path / "a.st"
    known = first.sources[0]
    other.edit(file, b"TYPE T_New : INT; END_TYPE")
    assert first.checking is not None
    touched = first_touched(first.checking, known, other.sources[0], ())
    assert touched == ({"t_own", "t_new"}, {"t_own", "t_new"})
    other.edit(file, b"TYPE CTU : INT; END_TYPE")
    assert first_touched(first.checking, known, other.sources[0], ()) is None
