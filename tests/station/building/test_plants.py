"""Units linked with PLCs, the NC and each other."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.station import ConfigError, Station

PROGRAM = """
PROGRAM MAIN
VAR
    fPump AT %QD0 : REAL;
    bFull AT %IX0.0 : BOOL;
    fLevel AT %ID4 : REAL;
    nCount AT %IW8 : INT;
    bFailed : BOOL;
    nDeed : INT;
    fSeen : LREAL;
    sName : STRING;
END_VAR
VAR CONSTANT
    cMost : LREAL := 1;
END_VAR
fPump := SEL(bFull, 2.0, 0.0);
END_PROGRAM
"""

TANK = """
[[plc]]
sources = "main.st"
[[fmu]]
name = "tank"
file = "tank2.fmu"
step = "20ms"
inputs = { pump = "MAIN.fPump" }
outputs = { "MAIN.fLevel" = "level", "MAIN.bFull" = "full" }
start = { area = 4.0, valve = 0.1 }
"""


def load(folder: Path, text: str) -> Station:
    (folder / "main.st").write_text(PROGRAM)
    (folder / "station.toml").write_text(text)
    return Station.load(folder / "station.toml")


def test_tank_is_filled_by_the_plc(put_unit: Callable[..., Path]) -> None:
    station = load(put_unit("tank2"), TANK)
    main = station.plcs[851].instance("MAIN")
    station.advance(0.5)
    assert 0.2 < main["fLevel"] < 0.25
    station.advance(3.5)
    assert 0.9 < main["fLevel"] < 1.1
    assert station.plants["tank"].time_ns == 4_000_000_000
    assert station.tick_ns == 10_000_000


def test_stopped_plc_gives_zero(put_unit: Callable[..., Path]) -> None:
    station = load(put_unit("tank2"), TANK)
    station.advance(0.1)
    assert station.plants["tank"].inputs == [2.0]
    station.plcs[851].stop()
    station.advance(0.1)
    assert station.plants["tank"].inputs == [0.0]


def test_units_pass_values_in_the_order_of_the_file(put_unit: Callable[..., Path]) -> None:
    first = '[[fmu]]\nname = "a"\nfile = "wild.fmu"\nstep = "10ms"\n'
    second = (
        '[[fmu]]\nname = "b"\nfile = "wild.fmu"\nstep = "10ms"\n'
        'inputs = { added = "fmu:a:value" }\n'
    )
    folder = put_unit("wild")
    forward = load(folder, first + second)
    forward.advance(0.02)  # a: 1, 2; b adds what a says now
    linked = forward.plants["b"]
    assert linked.inputs == [2.0]
    backward = load(folder, second + first)
    backward.advance(0.02)
    assert backward.plants["b"].inputs == [1.0]


def test_values_of_the_nc_are_inputs(put_unit: Callable[..., Path]) -> None:
    station = load(
        put_unit("conveyor"),
        '[[axis]]\nid = 1\nname = "X"\n[[fmu]]\nname = "belt"\nfile = "conveyor.fmu"\n'
        'step = "10ms"\ninputs = { speed = "500:Axes.X.OverrideV" }\n',
    )
    assert station.nc is not None
    station.nc.axis(1).velocity_override = 3
    station.advance(0.01)
    assert station.plants["belt"].inputs == [3.0]


def test_failure_is_seen_by_the_plc(put_unit: Callable[..., Path]) -> None:
    station = load(
        put_unit("wild"),
        '[[plc]]\nsources = "main.st"\n[[fmu]]\nname = "wild"\nfile = "wild.fmu"\n'
        'inputs = { deed = "MAIN.nDeed" }\noutputs = { "MAIN.fSeen" = "value" }\n'
        'failed = "MAIN.bFailed"\n',
    )
    main = station.plcs[851].instance("MAIN")
    station.advance(0.1)
    seen = main["fSeen"]
    assert (seen, main["bFailed"]) == (10.0, False)
    main["nDeed"] = 5  # not a number
    station.advance(0.1)
    assert (main["fSeen"], main["bFailed"]) == (seen, True)
    assert station.plants["wild"].failure == "value: expected a finite number, got nan"


def test_numbers_of_a_plc_and_a_unit_meet_their_limits(put_unit: Callable[..., Path]) -> None:
    """A REAL has its largest number for a larger one; a unit gets no number that is none."""
    station = load(
        put_unit("wild"),
        '[[plc]]\nsources = "main.st"\n[[fmu]]\nname = "wild"\nfile = "wild.fmu"\n'
        'inputs = { deed = "MAIN.nDeed", added = "MAIN.fPump" }\n'
        'outputs = { "MAIN.fLevel" = "value" }\n',
    )
    main = station.plcs[851].instance("MAIN")
    main["nDeed"] = 9  # 1e308
    station.advance(0.1)
    assert main["fLevel"] == pytest.approx(3.4028235e38)
    assert not station.plants["wild"].failure
    main["fPump"] = math.nan
    station.plants["wild"].exchange()
    assert "added: expected" in station.plants["wild"].failure
    assert station.plants["wild"].failure.endswith("got nan")
    assert main["fLevel"] == pytest.approx(3.4028235e38)


def test_links_survive_an_online_change(put_unit: Callable[..., Path]) -> None:
    folder = put_unit("tank2")
    station = load(folder, TANK)
    station.advance(0.1)
    text = PROGRAM.replace("bFailed : BOOL;", "bFailed : BOOL; aNew : ARRAY [0..9] OF LREAL;")
    text = text.replace("bFull AT", "bRenamed AT").replace("(bFull", "(FALSE")
    (folder / "main.st").write_text(text)
    station.online_change()
    station.advance(0.1)
    main = station.plcs[851].instance("MAIN")
    assert main["fLevel"] == pytest.approx(station.plants["tank"].outputs[0])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("tank2.fmu", "none.fmu", r"fmu\[1\]\.file: .*none\.fmu: No such file"),
        ("{ pump", "{ pmup", r"fmu\[1\]\.inputs: expected a variable of the unit, got 'pmup'"),
        ("{ pump", "{ level", r"fmu\[1\]\.inputs: level: expected input or parameter, got output"),
        ('"MAIN.fPump"', '"MAIN.fPmup"', r"inputs\.pump: expected a variable of the PLC"),
        ('"MAIN.fPump"', '"MAIN.sName"', r"inputs\.pump: expected a number or a BOOL"),
        ('"MAIN.fPump"', '"852:MAIN.x"', r"inputs\.pump: expected the port of a \[\[plc\]\]"),
        ('"MAIN.fPump"', '"fmu:none:x"', r"inputs\.pump: expected one of tank, got 'none'"),
        ('"MAIN.fPump"', '"fmu:tank:x"', r"inputs\.pump: expected a variable of the unit"),
        ('"MAIN.fPump"', '"500:Axes.X"', r"inputs\.pump: expected a number of the NC"),
        ('"MAIN.fLevel"', '"MAIN.cMost"', r"outputs\.MAIN\.cMost: MAIN\.cMost is a constant"),
        ('"level"', '"levle"', r"outputs\.MAIN\.fLevel: expected a variable of the unit"),
        ("area", "aera", r"fmu\[1\]\.start: expected a variable of the unit, got 'aera'"),
        ('"20ms"', '"1us"', "cycles: expected multiples of a tick"),
    ],
)
def test_wrong_links_are_refused(
    put_unit: Callable[..., Path], old: str, new: str, complaint: str
) -> None:
    assert old in TANK
    with pytest.raises(ConfigError, match=complaint):
        load(put_unit("tank2"), TANK.replace(old, new, 1))


AXIS = """
[nc]
cycle = "2ms"
[[axis]]
id = 1
name = "X"
max_velocity = 300.0
[[fmu]]
name = "belt"
file = "conveyor.fmu"
step = "1ms"
[[fmu.axis]]
axis = "X"
command = "speed"
position = "position"
"""


def test_unit_does_several_steps_in_a_cycle(put_unit: Callable[..., Path]) -> None:
    station = load(put_unit("conveyor"), AXIS)
    station.advance(0.1)
    plant = station.plants["belt"]
    assert (plant.period_ns, plant.step_s, plant.time_ns) == (2_000_000, 0.001, 100_000_000)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"1ms"', '"3ms"', r"fmu\[1\]\.step: expected the cycle of the NC, 2 ms, or a whole part"),
        ('axis = "X"', 'axis = "Y"', r"fmu\[1\]\.axis\[1\]\.axis: expected an axis of the NC"),
        ('"speed"', '"barrier"', r"axis\[1\]\.command: barrier: expected input or parameter"),
        ('"speed"', '"speed"\nenable = "speed"', r"axis\[1\]\.enable: speed gets its value from"),
        ('command =', 'increment = 1e-8\ncommand =', r"increment: expected at least 1\.65e-07"),
        (
            "[[fmu]]",
            "[[bus]]\n[[drive]]\naxis = 1\n[[fmu]]",
            r"fmu\[1\]\.axis\[1\]\.axis: axis 1 has a drive already",
        ),
    ],
)  # fmt: skip
def test_wrong_axes_are_refused(
    put_unit: Callable[..., Path], old: str, new: str, complaint: str
) -> None:
    with pytest.raises(ConfigError, match=complaint):
        load(put_unit("conveyor"), AXIS.replace(old, new, 1))


def test_step_is_needed_without_axes_and_plc(put_unit: Callable[..., Path]) -> None:
    with pytest.raises(ConfigError, match=r"fmu\[1\]\.step: expected without axes and PLC"):
        load(put_unit("tank"), '[[fmu]]\nname = "tank"\nfile = "tank.fmu"\n')


def test_unit_that_does_not_start_is_reported(
    put_unit: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.executable", "/bin/false")
    with pytest.raises(ConfigError, match=r"fmu\[1\]: tank does not start: its process ended with"):
        load(put_unit("tank2"), TANK)


def test_axis_on_a_bus_and_one_on_a_unit(put_unit: Callable[..., Path]) -> None:
    station = load(
        put_unit("conveyor"),
        AXIS + '[[axis]]\nid = 2\nname = "Y"\n[[bus]]\n[[drive]]\naxis = "Y"\n',
    )
    assert station.nc is not None
    for axis in station.nc:
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(2.0)
    assert [station.missing_condition(number) for number in (1, 2)] == ["", ""]
