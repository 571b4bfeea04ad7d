"""Drives on a bus behind the axes of a world, and what goes wrong with them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from achse.drive import Alarm
from achse.swarm.worlds.draws import Stream, moments
from achse.swarm.worlds.world import STATION, Act, DrawnAxis, World

_ALARMS = tuple(alarm.name for alarm in Alarm)

_FAULTS = (
    "alarm", "alarm", "sto", "main_power", "encoder_loss", "lost_frames", "link_break", "hang",
)  # fmt: skip


def with_drives(world: World) -> World:
    """Put axes of some worlds on drives, which have alarms and lose their cable."""
    draws = Stream(world.seed, "drives")
    if not draws.chance(0.2):
        return world
    chosen = sorted(draws.sample(range(len(world.axes)), draws.randrange(len(world.axes)) + 1))
    drives = [_drive(draws, world.axes[number]) for number in chosen]
    times = moments(draws, draws.decades(-1.5, -0.3), world.length_ns)
    acts = [Act(moment, STATION, "drive_fault", [_fault(draws, len(drives))]) for moment in times]
    return replace(
        world,
        machine={"bus": [{"name": "EtherCAT"}], "drive": drives},
        acts=sorted([*world.acts, *acts], key=lambda act: act.at_ns),
    )


def _drive(draws: Stream, part: DrawnAxis) -> Mapping[str, Any]:
    """Draw a drive whose motor turns some 3,000 times a minute at the maximum velocity."""
    top = part.values["max_velocity"]
    return {
        "axis": part.name,
        "mode": draws.choice(("csp", "csp", "csv")),
        "resolution": 1 << draws.randrange(13, 21),
        "gear": [1, 1],
        "feed": draws.rounded(top / 50.0 * draws.decades(0.0, 0.7)),
    }


def _fault(draws: Stream, count: int) -> Mapping[str, Any]:
    kind = draws.choice(_FAULTS)
    fields: dict[str, Any] = {"kind": kind, "lasting": draws.rounded(draws.decades(-2.0, 0.5))}
    if kind == "alarm":
        fields["code"] = draws.choice(_ALARMS)
    if kind != "lost_frames":
        fields["drive"] = draws.randrange(count) + 1
    return fields


def drive_axes(world: World) -> Sequence[str]:
    """Return the names of the axes on drives, in the order of the drives."""
    return [each["axis"] for each in world.machine.get("drive", ())]
