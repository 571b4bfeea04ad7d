"""Names by which an edit reaches units and routines."""

from pathlib import Path

from achse.st.workspace import Workspace
from achse.st.workspace.touched import Touched, WordIndex, first_touched


def _touched(workspace: Workspace, units: set[str], words: set[str]) -> Touched:
    checking = workspace.checking
    assert checking is not None
    entries = [one for one in checking.names.scopes.entries.values() if not one.is_library]
    return WordIndex().touched(workspace.sources, entries, Touched(units, words, set()), {"gvl"})


def test_units_are_touched_by_names_in_their_declarations(workspace: Workspace) -> None:
    units, words, _ = _touched(workspace, {"fb_drive"}, {"fb_drive"})
    assert units == {"fb_drive", "fb_fast", "gvl", "main"}
    assert {"gvl", "fbspare"} <= words
    assert not {"ncount", "cmost"} & words


def test_a_name_in_a_body_touches_no_unit(workspace: Workspace) -> None:
    assert _touched(workspace, {"f_add"}, {"f_add"}).units == {"f_add"}


def test_values_of_enumerations_need_no_prefix(workspace: Workspace) -> None:
    units, words, _ = _touched(workspace, {"e_state"}, {"e_state", "idle"})
    assert units == {"e_state", "main"}
    assert "moving" not in words


def test_words_before_a_dot_are_apart(workspace: Workspace) -> None:
    checking = workspace.checking
    assert checking is not None
    main = workspace.source_of(workspace.path / "POUs" / "MAIN.TcPOU")
    assert main is not None
    routines = [one for one in checking.routines.created if one.source is main]
    words = WordIndex().of_routines(main, routines)
    assert {"gvl.", "ncount", "fbdrive", "fbdrive.", "position"} <= words["main"]
    assert "gvl" not in words["main"]
    assert {"nold", "bool", "cmost"} <= words["main.reset"]


def test_a_name_of_a_library_touches_everything(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("TYPE T_Own : INT; END_TYPE")
    (tmp_path / "b.st").write_text("FUNCTION F : INT\nEND_FUNCTION")
    first, other = Workspace(tmp_path), Workspace(tmp_path)
    file = tmp_path / "a.st"
    known = first.sources[0]
    other.edit(file, b"TYPE T_New : INT; END_TYPE")
    assert first.checking is not None
    touched = first_touched(first.checking, known, other.sources[0], ())
    assert touched == ({"t_own", "t_new"}, {"t_own", "t_new"}, set())
    other.edit(file, b"TYPE CTU : INT; END_TYPE")
    assert first_touched(first.checking, known, other.sources[0], ()) is None
