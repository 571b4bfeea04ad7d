"""`achse axis couple` and `decouple`: axes that follow axes."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli import complete
from achse.cli.axes.axis import NC_PORT, AxisName
from achse.cli.options import Acceleration, Deceleration, Jerk
from achse.cli.output import decimal, print_json
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client

Master = Annotated[
    str, typer.Argument(metavar="MASTER", help="Id or name.", autocompletion=complete.axes)
]


class Joined(StrEnum):
    """Interpolation between the rows of a cam."""

    LINEAR = "linear"
    FOUR_POINTS = "four points"
    SPLINE = "spline"
    LOCAL = "local"


JoinedBy = Annotated[Joined, typer.Option("--joined", help="How the rows of a cam are joined.")]


class Then(StrEnum):
    """Behaviour of a slave that is decoupled in motion."""

    GO_ON = "go on"
    STOP = "stop"
    STOP_ORIENTED = "stop oriented"
    NEW_VELOCITY = "new velocity"
    NEW_POSITION = "new position"
    AT_ONCE = "at once"


def register(axis: typer.Typer) -> None:
    """Add the commands to `achse axis`."""
    client_command(axis, NC_PORT, signed=True)(couple)
    client_command(axis, NC_PORT)(decouple)


async def _report(client: "Client", name: str, in_json: bool, did: str) -> None:
    """Print the state of the slave."""
    from achse.cli.axes.nc import chosen

    [item] = await chosen(client, [name])
    online = await item.online()
    state = int(await item.remote.states["coupling_state"])
    if in_json:
        print_json(
            {
                "id": item.axis_id,
                "name": item.name,
                "coupling_state": state,
                "position": online["set_position"],
                "velocity": online["set_velocity"],
            }
        )
    else:
        here = f"{decimal(online['set_position'])} {item.unit}"
        print(f"{item}: {did}, is at {here}")


async def couple(
    client: "Client",
    name: AxisName,
    master: Master,
    ratio: Annotated[
        float | None,
        typer.Argument(
            help="Of a gear: slave units per master unit, not 0; either sign.", show_default="1"
        ),
    ] = None,
    change: Annotated[
        bool, typer.Option("--change", help="The slave follows already: a new ratio, at once.")
    ] = False,
    table: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=4095,
            help="Follow by this table of the NC, not by a gear.",
            show_default=False,
            rich_help_panel="Cam",
        ),
    ] = None,
    joined: JoinedBy = Joined.SPLINE,
    relative: Annotated[
        bool,
        typer.Option(
            "--relative", help="Count both axes from where they are now.", rich_help_panel="Cam"
        ),
    ] = False,
    master_offset: Annotated[
        float, typer.Option(help="Units of the master.", rich_help_panel="Cam")
    ] = 0.0,
    slave_offset: Annotated[
        float, typer.Option(help="Units of the slave.", rich_help_panel="Cam")
    ] = 0.0,
    master_scaling: Annotated[
        float, typer.Option(help="Stretches the cam, not 0.", rich_help_panel="Cam")
    ] = 1.0,
    slave_scaling: Annotated[
        float, typer.Option(help="Raises the cam.", rich_help_panel="Cam")
    ] = 1.0,
    in_json: Json = False,
) -> None:
    """Let an axis follow a master: by a gear, or by a cam table or motion function (--table).

    By a gear slave way = ratio · master way.
    """
    from achse.cli.axes.nc import chosen

    if table is not None and (ratio is not None or change):
        raise typer.BadParameter("RATIO and --change are of a gear; --table is none")
    slave, leader = await chosen(client, [name, master])
    remote = client.nc.axis(slave.axis_id)
    if table is None:
        ratio = 1.0 if ratio is None else ratio
        if change:
            await remote.change_gear(ratio)
        else:
            await remote.gear_in(leader.axis_id, ratio)
        await _report(client, name, in_json, f"follows {leader} by a gear of {ratio:g}")
        return
    await remote.cam_in(
        leader.axis_id,
        table,
        interpolation=joined.value,
        master_absolute=not relative,
        slave_absolute=not relative,
        master_offset=master_offset,
        slave_offset=slave_offset,
        master_scaling=master_scaling,
        slave_scaling=slave_scaling,
    )
    await _report(client, name, in_json, f"follows {leader} by table {table}")


async def decouple(
    client: "Client",
    name: AxisName,
    then: Annotated[
        Then, typer.Option(help="What a slave in motion does; one at rest stays.")
    ] = Then.GO_ON,
    position: Annotated[float, typer.Option(help="For a new position, or a stop at one.")] = 0.0,
    velocity: Annotated[float, typer.Option(help="For a new velocity or position.")] = 0.0,
    acceleration: Acceleration = 0.0,
    deceleration: Deceleration = 0.0,
    jerk: Jerk = 0.0,
    in_json: Json = False,
) -> None:
    """Let a slave go: it goes on at its velocity by default."""
    from achse.cli.axes.nc import chosen

    [slave] = await chosen(client, [name])
    await client.nc.axis(slave.axis_id).gear_out(
        then.value,
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        deceleration=deceleration,
        jerk=jerk,
    )
    await _report(client, name, in_json, "follows no axis")
