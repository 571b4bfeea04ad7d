"""Machines of drives from TOML: what is said counts, what is wrong is told."""

from pathlib import Path
from typing import Any

import pytest

from achse.drive.machine import MACHINES, EncoderKind
from achse.drive.signals import OutputFunction
from achse.station.configuration.documents import parse_toml
from achse.station.slaves.machine_file import MachineFileError, machines_of, read_machines

FILE = """
type = "linear"
brake = true
outputs = ["alarm", "in_position"]

[load]
inertia = 8
[encoder]
kind = "multi_turn"
[switches]
negative_stop = -50_000
home = [1000, 2000.5]
probe = [5000, 5100]

[[drive]]
type = "ac"
position = 700.0
switches = { positive_limit = 90000 }
[[drive]]
"""


def test_common_tables_and_those_of_each_drive(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text(FILE)
    one, two, three = read_machines(file, ["direct"] * 3)
    assert one.motor == MACHINES["ac"].motor
    assert two.motor == three.motor == MACHINES["linear"].motor
    assert two == three
    assert (one.position, two.position) == (700.0, 0.0)
    assert one.switches.positive_limit == 90_000.0
    assert two.switches.positive_limit is None
    for machine in (one, two):
        assert machine.brake
        assert machine.load.inertia == 8.0
        assert machine.encoder.kind is EncoderKind.MULTI_TURN
        assert machine.switches.home == (1000.0, 2000.5)
        assert machine.switches.probe == (5000.0, 5100.0)
        assert machine.outputs == (OutputFunction.ALARM, OutputFunction.IN_POSITION)


def test_without_a_word_the_types_of_the_command_line_count() -> None:
    assert machines_of({}, ["linear", "ac"]) == [MACHINES["linear"], MACHINES["ac"]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tpye = 'ac'", "tpye: no such key, there are motor"),
        ("type = 'steam'", "type: expected one of linear, direct, ac, got 'steam'"),
        ("brake = 1", "brake: expected true or false, got 1"),
        ("motor = 3", "motor: expected a table"),
        ("[motor]\ninertia = 'much'", "motor.inertia: expected a number, got 'much'"),
        ("[motor]\ninertia = 0", "motor.inertia = 0.0: expected more than 0"),
        ("[load]\ninertia = nan", "load.inertia: expected a finite number"),
        ("[encoder]\nresolution = 1.5", "encoder.resolution: expected a whole number"),
        ("[encoder]\nkind = 'optical'", "encoder.kind: expected one of incremental"),
        ("[switches]\nhome = [1]", "switches.home: expected a list of 2"),
        ("[switches]\nhome = [2, 1]", "switches.home: expected the smaller one first"),
        ("[switches]\nnegative_stp = 1", "did you mean 'negative_stop'"),
        ("outputs = ['smoke']", "outputs[1]: expected one of none, alarm"),
        ("drive = 3", "drive: expected [[drive]] tables"),
        ("[[drive]]\n[[drive]]", "up to 1 tables (--count), got 2"),
        ("[[drive]]\nposition = true", "drive[1].position: expected a number"),
        ("[[drive]]\ntype = 1", "drive[1].type: expected one of"),
    ],
)
def test_a_fault_is_reported(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError) as fault:  # noqa: PT011  # whose text is looked at
        machines_of(parse_toml(text), ["ac"])
    assert message in str(fault.value)
    file = tmp_path / "machine.toml"
    file.write_text(text)
    with pytest.raises(MachineFileError) as located:
        read_machines(file, ["ac"])
    assert str(located.value) == f"{file}: {fault.value}"


def test_what_is_not_toml_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text("[[")
    with pytest.raises(MachineFileError, match=r"machine\.toml"):
        read_machines(file, ["ac"])
    with pytest.raises(OSError, match="No such file"):
        read_machines(tmp_path / "none.toml", ["ac"])


def test_every_field_can_be_said() -> None:
    table: Any = {"switches": {"negative_limit": 1}, "gantry": True}
    assert machines_of(table, ["ac"])[0].gantry
