"""`achse axis` moves and shows axes, through the NC's ADS services and nothing else."""

import asyncio
import contextlib
from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli import complete
from achse.cli.failure import fail
from achse.cli.options import Acceleration, Deceleration, Jerk
from achse.cli.output import decimal, on_terminal, print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.axes.move import Course, Order
    from achse.cli.axes.nc import NcAxis
    from achse.client import Client

NC_PORT = 501

axis = typer.Typer(no_args_is_help=True, help="Move and watch the axes of an NC.")

AxisName = Annotated[
    str, typer.Argument(metavar="AXIS", help="Id or name.", autocompletion=complete.axes)
]
AxisNames = Annotated[
    list[str],
    typer.Argument(metavar="AXIS...", help="Ids or names.", autocompletion=complete.axes),
]
Wait = Annotated[bool, typer.Option("--wait/--no-wait", help="Follow it; Ctrl-C stops the axis.")]
Plot = Annotated[
    bool | None, typer.Option("--plot/--no-plot", help="Draw it.", show_default="on a terminal")
]
SampleTime = Annotated[float, typer.Option(min=0.001, max=429, help="Between samples, s.")]


class Direction(StrEnum):
    """Direction of an endless move."""

    POSITIVE = "+"
    NEGATIVE = "-"


class Way(StrEnum):
    """Direction in which a modulo position is reached."""

    SHORTEST = "shortest"
    POSITIVE = "+"
    NEGATIVE = "-"


async def show_state(item: "NcAxis") -> None:
    """Print the state of one axis."""
    from achse.ams.errors import describe_code
    from achse.cli.axes.nc import motion_state
    from achse.client.nc.access import FULL_OVERRIDE
    from achse.client.nc.status import flag_names

    online = await item.online()

    def figure(name: str, per: str = "") -> str:
        return f"{decimal(online[name]):>14} {item.unit}{per}"

    print(f"{item.axis_id} {item.name}: {motion_state(online['state_dword'])}")
    print(f"  position         {figure('actual_position')}  set {figure('set_position')}")
    print(
        f"  velocity         {figure('actual_velocity', '/s')}  set {figure('set_velocity', '/s')}"
    )
    print(f"  following error  {figure('following_error')}")
    print(f"  override         {online['velocity_override'] / FULL_OVERRIDE:>14g} %")
    code = online["error_code"]
    print(f"  error            {describe_code(code) if code else 'none':>14}")
    print(f"  flags            {', '.join(flag_names(online['state_dword']))}".rstrip())


async def report(axes: Sequence["NcAxis"], in_json: bool) -> None:
    """Print a line per axis, in JSON its online structure."""
    from achse.ams.errors import describe_code
    from achse.cli.axes.nc import motion_state
    from achse.client.nc.status import flag_names

    states = await asyncio.gather(*(item.online() for item in axes))
    if in_json:
        print_json(
            [
                {
                    "id": item.axis_id,
                    "name": item.name,
                    "unit": item.unit,
                    "state": motion_state(online["state_dword"]),
                    "flags": flag_names(online["state_dword"]),
                    **online,
                }
                for item, online in zip(axes, states, strict=True)
            ]
        )
        return
    rows = [
        (
            str(item.axis_id),
            item.name,
            decimal(online["actual_position"]),
            item.unit,
            decimal(online["actual_velocity"]),
            f"{item.unit}/s",
            motion_state(online["state_dword"]),
            describe_code(online["error_code"]) if online["error_code"] else "",
        )
        for item, online in zip(axes, states, strict=True)
    ]
    if rows:
        print_table(rows, right=frozenset({0, 2, 4}))


@client_command(axis, NC_PORT)
async def enable(
    client: "Client",
    names: AxisNames,
    override: Annotated[float, typer.Option(min=0, max=100, help="Percent.")] = 100.0,
    in_json: Json = False,
) -> None:
    """Enable axes for motion in both directions, and wait until they are ready."""
    from achse.cli.axes.nc import chosen

    axes = await chosen(client, names)
    within = client.timeout
    await asyncio.gather(*(item.remote.enable(override=override, within=within) for item in axes))
    await report(axes, in_json)


@client_command(axis, NC_PORT)
async def disable(client: "Client", names: AxisNames, in_json: Json = False) -> None:
    """Take the enables of axes away."""
    from achse.cli.axes.nc import chosen

    axes = await chosen(client, names)
    await asyncio.gather(*(item.remote.disable(within=client.timeout) for item in axes))
    await report(axes, in_json)


@client_command(axis, NC_PORT)
async def stop(
    client: "Client",
    names: AxisNames,
    deceleration: Annotated[
        float | None, typer.Option(help="Units/s²; that of the running command.")
    ] = None,
    jerk: Annotated[float | None, typer.Option(help="Units/s³, with --deceleration.")] = None,
    in_json: Json = False,
) -> None:
    """Stop axes, and wait until they stand."""
    from achse.cli.axes.nc import chosen

    if (deceleration is None) != (jerk is None):
        raise typer.BadParameter("--deceleration and --jerk go together")
    axes = await chosen(client, names)
    stops = [
        await item.remote.stop(deceleration=deceleration or 0.0, jerk=jerk or 0.0, wait=False)
        for item in axes
    ]
    await asyncio.gather(*(each.finished() for each in stops))
    await report(axes, in_json)


@client_command(axis, NC_PORT)
async def reset(client: "Client", names: AxisNames, in_json: Json = False) -> None:
    """Reset axes: acknowledge their errors."""
    from achse.cli.axes.nc import chosen

    axes = await chosen(client, names)
    await asyncio.gather(*(item.remote.reset(within=client.timeout) for item in axes))
    await report(axes, in_json)


@client_command(axis, NC_PORT)
async def move(
    client: "Client",
    name: AxisName,
    to: Annotated[
        float | None, typer.Option(metavar="POSITION", help="Where to.", show_default=False)
    ] = None,
    by: Annotated[
        float | None,
        typer.Option("--by", "--relative", metavar="DISTANCE", help="How far.", show_default=False),
    ] = None,
    endless: Annotated[
        Direction | None, typer.Option(help="On and on, that way.", show_default=False)
    ] = None,
    modulo: Annotated[
        Way | None,
        typer.Option(help="--to is a modulo position, reached that way.", show_default=False),
    ] = None,
    velocity: Annotated[
        float | None,
        typer.Option(
            "--velocity", "-v", help="Units/s.", show_default="rapid traverse of the axis"
        ),
    ] = None,
    acceleration: Acceleration = 0.0,
    deceleration: Deceleration = 0.0,
    jerk: Jerk = 0.0,
    wait: Wait = True,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Move an axis and follow it to the end."""
    from achse.cli.axes.move import Order, follow, own_velocity, start
    from achse.cli.axes.nc import chosen

    start_type, position = _start_type(to, by, endless, modulo)
    [item] = await chosen(client, [name])
    if velocity is None:
        velocity, meaning = await own_velocity(item)
        if not in_json:
            print(f"{item}: {velocity:g} {item.unit}/s, its {meaning}")
    order = Order(start_type, position, velocity, acceleration, deceleration, jerk)
    if not wait:
        number = await start(item, order)
        if in_json:
            print_json({"id": item.axis_id, "name": item.name, "command": number})
        else:
            print(f"{item}: command {number} accepted")
        return
    course = await follow(item, order, sample_time)
    if in_json:
        print_json(_course_json(item, order, course))
    else:
        _report(item, course, on_terminal() if plot is None else plot)
    if course.trouble is not None:
        fail(course.trouble)


@client_command(axis, NC_PORT)
async def home(
    client: "Client",
    name: AxisName,
    wait: Wait = True,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Home an axis as its reference mode says, and follow it to the end."""
    from achse.cli.axes.home import Homing
    from achse.cli.axes.move import follow
    from achse.cli.axes.nc import chosen

    [item] = await chosen(client, [name])
    if not wait:
        await Homing().begin(item)
        await report([item], in_json)
        return
    course = await follow(item, Homing(), sample_time)
    if in_json:
        print_json(_homing_json(item, course))
    else:
        draw(course, on_terminal() if plot is None else plot)
        for moment, step in course.steps:
            print(f"{item}: {moment:8.3f} s  {step.lower().replace('_', ' ')}")
        if course.trouble is None:
            here = f"{decimal(course.target)} {item.unit}"
            print(f"{item}: homed in {course.seconds:.3f} s, is at {here}")
    if course.trouble is not None:
        fail(course.trouble)


def _start_type(
    to: float | None, by: float | None, endless: Direction | None, modulo: Way | None
) -> tuple[Any, float]:
    """Return the start type and the position that goes with it."""
    from achse.codes.axis import StartType

    if sum(wish is not None for wish in (to, by, endless)) != 1:
        raise typer.BadParameter("one of --to, --by and --endless says where")
    if modulo is not None and to is None:
        raise typer.BadParameter("--modulo goes with --to")
    if endless is not None:
        return StartType[f"ENDLESS_{endless.name}"], 0.0
    if by is not None:
        return StartType.RELATIVE, by
    assert to is not None
    return StartType.ABSOLUTE if modulo is None else StartType[f"MODULO_{modulo.name}"], to


def draw(course: "Course", wanted: bool) -> None:
    """Draw the move."""
    if wanted:
        from rich.console import Console

        console = Console(highlight=False)
        console.print(course.trace.text(min(console.width, 100)))


def _report(item: "NcAxis", course: "Course", drawn: bool) -> None:
    """Print the move in a sentence, and draw it."""
    trace, unit = course.trace, item.unit
    begin, end = (decimal(trace["actual_position"][place], 3) for place in (0, -1))
    draw(course, drawn)
    print(
        f"{item}: {begin} → {end} {unit} in {course.seconds:.3f} s,"
        f" peak velocity {decimal(trace.peak('actual_velocity'), 2)} {unit}/s,"
        f" peak following error {decimal(trace.peak('following_error'))} {unit}"
    )


def _homing_json(item: "NcAxis", course: "Course") -> dict[str, Any]:
    trace = course.trace
    return {
        "id": item.axis_id,
        "name": item.name,
        "unit": item.unit,
        "done": course.trouble is None,
        "trouble": course.trouble,
        "position": trace["actual_position"][-1],
        "seconds": course.seconds,
        "steps": [{"step": step, "time": moment} for moment, step in course.steps],
        "trace": {"time": trace.times, **trace.columns},
    }


def _course_json(item: "NcAxis", order: "Order", course: "Course") -> dict[str, Any]:
    trace = course.trace
    return {
        "id": item.axis_id,
        "name": item.name,
        "unit": item.unit,
        "start_type": order.start_type.name,
        "done": course.trouble is None,
        "trouble": course.trouble,
        "begin": trace["actual_position"][0],
        "target": course.target,
        "end": trace["actual_position"][-1],
        "seconds": course.seconds,
        "velocity": order.velocity,
        "peak_velocity": trace.peak("actual_velocity"),
        "peak_following_error": trace.peak("following_error"),
        "trace": {"time": trace.times, **trace.columns},
    }


async def watch_axis(
    item: "NcAxis", cycle_time: float, count: int | None, duration: float | None, in_json: bool
) -> None:
    """Show samples of an axis: a picture on a terminal, else a line per sample."""
    from achse.cli.axes.watch import shown

    left = count
    with shown(item, in_json) as show, contextlib.suppress(TimeoutError):
        async with asyncio.timeout(duration), item.samples(cycle_time) as samples:
            async for sample in samples:
                show(sample, item.sample(sample.value))
                if left is not None:
                    left -= 1
                    if left == 0:
                        break
