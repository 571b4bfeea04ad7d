"""What a name that is not there may mean."""

import random

import pytest

from achse.client.session.hints import hint_for, hint_inside
from achse.iec import ARRAY, INT, LREAL, Struct, iec_type, var
from achse.iec.derived import ReferenceType
from achse.iec.symbols import SymbolEntry, fold


class ST_Axis(Struct):  # noqa: N801
    fVelocity = var(LREAL)  # noqa: N815
    aParts = var(ARRAY(INT, (1, 3)))  # noqa: N815


NAMES = ["MAIN.nCounter", "MAIN.stAxis", "GVL.a", "GVL.b", "GVL.c", "GVL.d", "GVL.e", "One.x"]
LISTED = {fold(name): SymbolEntry.of(name, INT, 0x4040, 0) for name in NAMES}


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("MAIN.nCuonter", "; did you mean 'MAIN.nCounter'?"),
        ("main.NCOUNTER", ""),
        ("GVL", "; GVL holds 5 symbols: GVL.a, GVL.b, GVL.c, GVL.d, …"),
        (" gvl.", "; gvl holds 5 symbols: GVL.a, GVL.b, GVL.c, GVL.d, …"),
        ("One", "; One holds 1 symbol: One.x"),
        ("MIAN", "; did you mean 'MAIN'?"),
        ("nCounter", "; did you mean 'MAIN.nCounter'?"),
        ("something else", ""),
        ("", ""),
        (".", ""),
    ],
)
def test_of_names_that_are_no_symbols(name: str, hint: str) -> None:
    assert hint_for(name, LISTED) == hint


@pytest.mark.parametrize(
    ("rest", "hint"),
    [
        (".fVelocity", ""),
        (".fVelocty", "; ST_Axis has no member 'fVelocty'; did you mean 'fVelocity'?"),
        (".other", "; ST_Axis has no member 'other'; it has fVelocity, aParts"),
        (".aParts[4]", "; index 4 is outside 1..3 of ARRAY [1..3] OF INT"),
        (".aParts[1].x", "; INT has no member 'x'"),
        ("^", "; ST_Axis is not a pointer: ^ leads nowhere"),
        ("[", "; path '[': expected an index at position 1, got the end"),
    ],
)
def test_of_paths_that_leave_their_symbol(rest: str, hint: str) -> None:
    assert hint_inside(iec_type(ST_Axis), rest) == hint
    assert hint_inside(ReferenceType(iec_type(ST_Axis)), rest).startswith(hint) or rest == "^"


def test_any_text_has_a_hint_or_none() -> None:
    chance = random.Random(12)
    signs = "abM.[]^#1, \0ä" * 3 + "GVL"
    for _ in range(2000):
        text = "".join(chance.choices(signs, k=chance.randrange(0, 12)))
        for hint in (hint_for(text, LISTED), hint_inside(iec_type(ST_Axis), text)):
            assert hint == "" or hint.startswith("; ")
