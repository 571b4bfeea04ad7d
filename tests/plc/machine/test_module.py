"""Modules: what stays plain, tables of methods, notes for the cache."""

from collections.abc import Callable
from typing import Any

from achse.plc.machine.fault_places import FaultKind, FaultPlaces
from achse.plc.machine.module import ModuleNotes

Run = Callable[..., Any]


def test_notes_come_back_from_the_cache() -> None:
    sites = FaultPlaces()
    sites.number(3, 5, FaultKind.ACCESS)
    notes = ModuleNotes(sites, {"main": 0}, [("a", "b")], [(1, 2)], ["start"], {"f": "why"})
    again = ModuleNotes.unpacked(notes.packed())
    assert again.sites[1] == (3, 5, FaultKind.ACCESS)
    assert (again.entries, again.callbacks) == ({"main": 0}, [("a", "b")])
    assert (again.outside, again.texts, again.plain_routines) == ([(1, 2)], ["start"], {"f": "why"})


def test_what_stays_plain_is_reported(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR q : POINTER TO INT; END_VAR q := __NEW(INT); __DELETE(q); F := 3;"
        " END_FUNCTION\nPROGRAM MAIN VAR x : INT; END_VAR x := F(); END_PROGRAM"
    )
    assert ran["x"] == 3
    if ran.twin is not None:
        assert ran.plain_routines["f"] == "__NEW is done by Python"
        assert "main" not in ran.plain_routines


def test_methods_of_interfaces_and_of_derived_blocks(run: Run) -> None:
    ran = run(
        "INTERFACE I METHOD M : INT VAR_INPUT n : INT; END_VAR END_METHOD END_INTERFACE\n"
        "FUNCTION_BLOCK A IMPLEMENTS I VAR k : INT := 1; END_VAR METHOD M : INT VAR_INPUT n : INT;"
        " END_VAR M := n + k; END_METHOD METHOD N : INT N := M(10); END_METHOD END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK B EXTENDS A METHOD M : INT VAR_INPUT n : INT; END_VAR M := n * 2 +"
        " SUPER^.M(n); END_METHOD END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR a : A; b : B; i : I; x, y, z : INT; END_VAR"
        " i := a; x := i.M(5); i := b; y := i.M(5); z := b.N(); END_PROGRAM"
    )
    assert (ran["x"], ran["y"], ran["z"]) == (6, 16, 31)
