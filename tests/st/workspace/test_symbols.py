"""Symbols: declared names."""

from pathlib import Path

from achse.st.workspace import Workspace
from achse.st.workspace.symbols import parameters_of, symbol_of_unit, visible_in


def test_symbols_are_one_for_each_declaration(workspace: Workspace) -> None:
    assert workspace.checking is not None
    entries = workspace.checking.names.scopes.entries
    assert symbol_of_unit(entries["fb_drive"]) == symbol_of_unit(entries["fb_drive"])
    assert symbol_of_unit(entries["fb_drive"]) != symbol_of_unit(entries["fb_fast"])


def test_the_name_of_a_list_is_in_its_file_alone(workspace: Workspace) -> None:
    assert workspace.checking is not None
    entries = workspace.checking.names.scopes.entries
    assert symbol_of_unit(entries["gvl"]).at is None
    place = symbol_of_unit(entries["fb_drive"]).at
    assert place == entries["fb_drive"].source.text.index("FB_Drive")


def test_names_that_a_routine_sees(workspace: Workspace, sample_folder: Path) -> None:
    checking = workspace.checking
    assert checking is not None
    method = checking.checked("fb_fast.move")
    assert method is not None
    assert [one.name for one in parameters_of(checking, method)] == ["nSteps"]
    names = {one.name for one in visible_in(checking, method)}
    assert {"nSteps", "cFactor", "nPosition", "Halt", "nCount", "Idle", "F_Add"} <= names
    assert "nSum" not in names
