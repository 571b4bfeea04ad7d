"""The hardware port: what passes between NC and machine, and that nothing else does."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion import commands
from achse.motion.fields.declare import Field
from achse.motion.port import DRIVE_IO, ENCODER_IO, within_32_bits, wrapped
from achse.motion.record import CONTROLLER, DRIVE, ENCODER, LAYOUT
from achse.native.declare import RecordLayout

MOTION = Path(__file__).parents[2] / "src" / "achse" / "motion"

KNOW_THE_MACHINE = {"axis.py", "compiled.py", "kernel.py", "nc.py", "retained.py",
                    "parts.py", "tables/characteristics.py",
                    "commands/positions.py", "elements.py"}  # fmt: skip
"""Modules that put the NC and its machine together, keep where it is, or ask a drive to count from
another number. None of them is a supervision."""


def imported(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}


def test_the_nc_knows_nothing_of_the_machine() -> None:
    for path in MOTION.rglob("*.py"):
        name = path.relative_to(MOTION).as_posix()
        text = path.read_text(encoding="utf-8")
        if name.startswith("machine/") or name in KNOW_THE_MACHINE:
            continue
        assert not any(module.startswith("achse.motion.machine") for module in imported(path)), name
        assert not re.search(r"(?<!motion)\.(machine|sensor|amplifier)\b", text), name
        assert "simulation_" not in text.replace("simulation_ideal", ""), name


def test_the_machine_knows_nothing_of_the_nc() -> None:
    allowed = ("achse.motion.machine", "achse.motion.port", "achse.motion.fields.declare",
               "achse.motion.fields.often",
               "achse.motion.control.curves", "achse.motion.states", "achse.motion.views",
               "achse.native")  # fmt: skip
    for path in (MOTION / "machine").rglob("*.py"):
        for module in imported(path):
            if module.startswith("achse") and path.name != "hardware.py":  # which builds it
                assert module.startswith(allowed), (path.name, module)


def references(layout: RecordLayout[Field]) -> dict[str, RecordLayout[Field]]:
    return {name: row.refers for name, row in layout.fields.items() if row.refers}


def test_an_axis_record_has_the_structures_and_no_other_way_to_hardware() -> None:
    assert references(LAYOUT) == {"encoder": ENCODER, "controller": CONTROLLER, "drive": DRIVE}
    assert references(ENCODER) == {"io": ENCODER_IO, "axis": LAYOUT}
    assert references(CONTROLLER) == {}
    assert references(DRIVE) == {"io": DRIVE_IO}


@given(st.integers(-(2**62), 2**62))
def test_a_double_word_of_a_count(value: int) -> None:
    assert wrapped(value) == int.from_bytes(
        (value & 0xFFFF_FFFF).to_bytes(4, "little"), "little", signed=True
    )


@pytest.mark.parametrize(
    ("value", "word"),
    [(0.5, 0), (1.5, 2), (-2.5, -2), (1e300, 2**31 - 1), (-1e300, -(2**31)), (7.4, 7)],
)
def test_the_nearest_increment(value: float, word: int) -> None:
    assert within_32_bits(value) == word


@pytest.mark.parametrize("compiled", [False, True])
def test_inputs_that_change_wake_an_axis(make_rig: Any, compiled: bool) -> None:
    """Anyone who is behind the port: here nobody but this test moves the encoder."""
    rig = make_rig(compiled=compiled, control_dword=0)
    rig.seconds(2.0)
    assert rig.axis.resting == 1
    rig.axis.encoder.io.data_in1 = 5000
    rig.axis.encoder.io.has_changed = 1
    rig.run(1)
    assert rig.axis.resting == 0
    assert rig.axis.actual_position == pytest.approx(0.5)


def test_a_machine_that_moves_while_the_axis_rests_is_seen(make_rig: Any) -> None:
    rig = make_rig(control_dword=0)
    rig.seconds(2.0)
    rig.axis.simulation_drift = 50.0
    rig.seconds(1.0)
    assert rig.axis.actual_velocity == pytest.approx(50.0, rel=1e-3)
    rig.axis.simulation_drift = 0.0
    rig.seconds(3.0)
    assert rig.axis.resting == 1


def test_only_what_is_in_the_structures_moves_the_machine(make_rig: Any) -> None:
    """The same outputs, written by hand, do what the NC does with them."""
    rig, other = make_rig(), make_rig(compiled=False)
    commands.start(rig.axis, 1, 50.0, 200.0)
    machine = other.nc._hardware

    for _ in range(300):
        rig.run(1)
        for name in DRIVE_IO.fields:
            if "_out" in name or name.startswith("ctrl"):
                setattr(other.axis.drive.io, name, getattr(rig.axis.drive.io, name))
        other.axis.drive.io.fresh = 1
        machine.step(rig.dt)
        assert other.axis.machine.position == rig.axis.machine.position
