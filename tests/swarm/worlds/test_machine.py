"""Drives on a bus are drawn into some worlds, with what goes wrong with them."""

from achse.drive import Alarm
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.machine import drive_axes

WORLDS = [world for seed in range(40) if "drive" in (world := draw_world(seed)).machine]


def test_each_drive_moves_an_axis_of_its_world() -> None:
    assert 3 < len(WORLDS) < 20
    for world in WORLDS:
        names = drive_axes(world)
        assert len(set(names)) == len(names) > 0
        assert set(names) <= {axis.name for axis in world.axes}


def test_faults_name_drives_that_are_there_and_known_alarms() -> None:
    kinds = set()
    for world in WORLDS:
        for act in world.acts:
            if act.kind == "drive_fault":
                (fields,) = act.values
                kinds.add(fields["kind"])
                assert 1 <= fields.get("drive", 1) <= len(drive_axes(world))
                assert fields.get("code", "") in {"", *(alarm.name for alarm in Alarm)}
    assert {"sto", "link_break"} <= kinds
