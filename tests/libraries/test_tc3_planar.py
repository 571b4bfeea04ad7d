"""Tc3_Physics and Tc3_Mc3PlanarMotion: places in the plane, and commands that no mover takes."""

import cmath
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

GEOMETRY = (
    "PROGRAM MAIN VAR a, b, inverse, both : PositionXYC; p, q, polar : PositionXY;"
    " n : ARRAY [1..8] OF LREAL; rest : ARRAY [1..9] OF LREAL; k : DynamicConstraint_PathXY;"
    " sum : LREAL; END_VAR a.SetValuesXYCReferenceId(n[1], n[2], n[3], 7);"
    " b.SetValuesXYC(n[4], n[5], n[6]); both.SetValues(a); both.ConcatenateWith(b);"
    " inverse.SetValues(a); inverse.Invert(); inverse.ConcatenateWith(a);"
    " p.SetValuesXY(n[7], n[8]); q.SetValues(p); a.Transform(q);"
    " polar.SetValuesRP(p.GetRadius(), p.GetPhi()); rest[1] := both.x; rest[2] := both.y;"
    " rest[3] := both.c; rest[4] := q.x; rest[5] := q.y; rest[6] := polar.x; rest[7] := polar.y;"
    " q.SetValuesXYReferenceId(n[1], n[2], a.ReferenceId); q.Invert(); q.ConcatenateWith(p);"
    " q.ShiftByXY(1, 2); a.StepByLocalXY(n[7], n[8]); a.ShiftByXY(1, 2); a.TurnByC(5);"
    " k.SetValuesVADJ(1, 2, 4, 8); k.V := k.V + 16; sum := k.V + k.A + k.D + k.J;"
    " IF n[1] > 1E9 THEN q.SetZero(); a.SetZero(); a.SetValuesXY(1, 2); a.x := 3; a.y := 4;"
    " a.c := 5; q.x := 6; q.y := 7; q.ReferenceId := 8; END_IF"
    " rest[8] := q.x; rest[9] := q.y; END_PROGRAM"
)


@pytest.fixture(scope="module")
def geometry() -> Ran:
    return Ran(GEOMETRY)


@settings(max_examples=12, deadline=None)
@given(st.lists(st.floats(-1000, 1000), min_size=8, max_size=8))
def test_places_are_turns_and_shifts(geometry: Ran, n: list[float]) -> None:
    main: Any = geometry.plc.instance("MAIN")
    for index, value in enumerate(n, start=1):
        main["n"][index] = value
    geometry.cycle()
    assert geometry.plc.failure == ""
    a, b, p = complex(*n[:2]), complex(*n[3:5]), complex(*n[6:])
    turn = cmath.exp(1j * math.radians(n[2]))
    both, moved = a + turn * b, a + turn * p
    shifted = p - a + (1 + 2j)
    wanted = [both.real, both.imag, n[2] + n[5], moved.real, moved.imag, p.real, p.imag]
    assert list(main["rest"]) == pytest.approx([*wanted, shifted.real, shifted.imag], abs=1e-6)
    inverse = main["inverse"]
    assert [inverse["px"], inverse["py"], inverse["pc"]] == pytest.approx([0, 0, 0], abs=1e-6)
    stepped = moved + (1 + 2j)
    place = main["a"]
    assert [place["px"], place["py"]] == pytest.approx([stepped.real, stepped.imag], abs=1e-6)
    assert place["pc"] == pytest.approx(n[2] + 5)
    assert (main["q"]["system"], main["sum"]) == (7, 31)


def test_constants_of_places() -> None:
    ran = Ran(GEOMETRY)
    main: Any = ran.plc.instance("MAIN")
    main["n"][1] = 2e9
    ran.cycle()
    assert [main["a"][name] for name in ("px", "py", "pc")] == [3, 4, 5]
    assert [main["q"][name] for name in ("px", "py", "system")] == [6, 7, 8]


def test_commands_end_with_the_error_of_a_missing_device() -> None:
    commands = (
        *("mover.Enable(f)", "mover.MoveToPosition(f, place, limits, options)"),
        *("mover.MoveZ(f, 2, limits)", "mover.Halt(f, limits)", "mover.AddToGroup(f, group)"),
        *("mover.MoveC(f, 90, limits, turn)", "mover.JoinTrack(f, track, limits, join)"),
        *("track.AppendLine(f, place, other)", "track.Enable(f)", "track.AddToGroup(f, group)"),
        *("group.Enable(f)", "group.Reset(f)", "environment.AddStator(f, 0, 0)"),
    )
    cases = "".join(f"{number}: {command};" for number, command in enumerate(commands))
    ran = Ran(
        "PROGRAM MAIN VAR mover : MC_PlanarMover; track : MC_PlanarTrack; group : MC_PlanarGroup;"
        " environment : MC_PlanarEnvironment; place, other : PositionXYC;"
        " trail : MC_PlanarTrackTrail;"
        " limits : DynamicConstraint_PathXY; turn : ST_MoveCOptions; join : ST_JoinTrackOptions;"
        " options : Tc3_Mc3PlanarMotion.ST_MoveToPositionOptions; f, fresh : MC_PlanarFeedback;"
        " d : Tc3_Mc3PlanarMotion.MC_DIRECTION := mcDirectionShortestWay; n : INT; x : LREAL;"
        " before, after : ARRAY [0..12] OF BOOL; code : UDINT; kind : UINT; END_VAR"
        " mover.Update(); mover.Enable(0); track.Update(); group.Update(); fresh.Update();"
        f" CASE n OF {cases} END_CASE before[n] := f.Error; f.Update(); after[n] := f.Error;"
        " code := f.ErrorId; kind := mover.GetPlanarObjectInfo().ObjectType;"
        " x := mover.MCTOPLC.SET.SetPos.x + mover.MCTOPLC.ACT.ActPos.y + track.GetLength();"
        " mover.GetPositionOnCurrentPart(other); trail.AddTrack(track);"
        " n := (n + 1) MOD 13; END_PROGRAM"
    ).cycle(13)
    assert ran.plc.failure == ""
    assert ran["before"] == [False] * 13
    assert ran["after"] == [True] * 13
    assert (ran["code"], ran["kind"], ran["x"], ran["d"]) == (6, 302, 0, 2)
    assert not ran["fresh.Error"]
    assert ran["trail.Size"] == 13
