"""`achse axis jog` and `achse axis excite` move an axis for a time, and follow it."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.axes.axis import NC_PORT, AxisName, Plot, SampleTime, draw
from achse.cli.failure import fail
from achse.cli.output import decimal, on_terminal, print_json
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.axes.excitation import Excitation
    from achse.cli.axes.move import Course
    from achse.cli.axes.nc import NcAxis
    from achse.client import Client

FREQUENCIES = 20
"""Of a sweep."""

PER_PERCENT = 10.0
"""Torque of 1 %, as the NC counts it."""

Duration = Annotated[float, typer.Option("--for", metavar="SECONDS", min=0.01, help="How long.")]


class Speed(StrEnum):
    """The manual velocities of an axis."""

    SLOW = "slow"
    FAST = "fast"
    RAPID = "rapid"


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    client_command(app, NC_PORT)(jog)
    client_command(app, NC_PORT)(excite)


async def jog(
    client: "Client",
    name: AxisName,
    speed: Annotated[Speed, typer.Option(help="Which manual velocity of the axis.")] = Speed.SLOW,
    negative: Annotated[
        bool, typer.Option("--negative", "-n", help="To smaller positions.")
    ] = False,
    duration: Duration = 1.0,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Move at a manual velocity, as long as a key would be pressed; Ctrl-C releases it earlier."""
    from achse.cli.axes.excitation import Excitation
    from achse.codes.axis import JogType

    start_type = JogType[speed.name] + negative  # the other direction is one more
    excitation = Excitation("start", (start_type, 0.0, 0.0), duration)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


async def excite(
    client: "Client",
    name: AxisName,
    between: Annotated[
        tuple[float, float] | None,
        typer.Option(
            metavar="POSITION POSITION",
            help="Move to and fro between these targets.",
            show_default=False,
            rich_help_panel="Reversing",
        ),
    ] = None,
    velocity: Annotated[
        float,
        typer.Option(
            "--velocity", "-v", help="Units/s.", show_default=False, rich_help_panel="Reversing"
        ),
    ] = 0.0,
    pause: Annotated[
        float, typer.Option(min=0.0, help="At each target, s.", rich_help_panel="Reversing")
    ] = 0.0,
    amplitude: Annotated[
        float | None,
        typer.Option(
            help="Swing with this velocity amplitude, units/s.",
            show_default=False,
            rich_help_panel="Sine",
        ),
    ] = None,
    frequency: Annotated[float, typer.Option(max=10.0, help="Hz.", rich_help_panel="Sine")] = 1.0,
    sweep: Annotated[
        tuple[float, float],
        typer.Option(
            metavar="HZ HZ",
            help="A second sine goes through these frequencies.",
            rich_help_panel="Sine",
        ),
    ] = (1.0, 1.0),
    signal: Annotated[
        float,
        typer.Option(help="Velocity amplitude of the second, units/s.", rich_help_panel="Sine"),
    ] = 0.0,
    torque: Annotated[
        float | None,
        typer.Option(
            metavar="PERCENT",
            help="Drive by this torque, in percent of the rated one, signed.",
            show_default=False,
            rich_help_panel="Torque",
        ),
    ] = None,
    limit: Annotated[
        float | None,
        typer.Option(
            help="Velocity that it keeps to, units/s.",
            show_default=False,
            rich_help_panel="Torque",
        ),
    ] = None,
    ramp: Annotated[
        float, typer.Option(min=0.0, help="%/s; 0 = at once.", rich_help_panel="Torque")
    ] = 0.0,
    duration: Duration = 5.0,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Excite an axis: to and fro (--between), by a sine (--amplitude) or by its torque (--torque).

    Ctrl-C stops it earlier; it ends in position control.
    """
    if sum(way is not None for way in (between, amplitude, torque)) != 1:
        raise typer.BadParameter("one of --between, --amplitude and --torque says how")
    if between is not None:
        if not velocity:
            raise typer.BadParameter("--between needs --velocity")
        excitation = _reversing(between, velocity, pause, duration)
    elif amplitude is not None:
        excitation = _swinging(amplitude, frequency, sweep, signal, duration)
    else:
        assert torque is not None
        if limit is None:
            raise typer.BadParameter("--torque needs --limit, a velocity")
        excitation = _driven_by_torque(torque, ramp, limit, duration)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


def _reversing(
    between: tuple[float, float], velocity: float, pause: float, duration: float
) -> "Excitation":
    """Return the excitation that moves an axis to and fro."""
    from achse.cli.axes.excitation import Excitation

    return Excitation("start_reversing_positioning", (1, *between, velocity, pause), duration)


def _swinging(
    amplitude: float, frequency: float, sweep: tuple[float, float], signal: float, duration: float
) -> "Excitation":
    """Return the excitation by one sine, or by a second one that goes through frequencies."""
    from achse.cli.axes.excitation import Excitation

    count = FREQUENCIES if signal else 1
    arguments = (
        1, amplitude, frequency, signal, 1.0, *sweep, duration / count, count, 1,
    )  # fmt: skip
    # a little longer than it takes, so that it ends by itself
    return Excitation("start_sine_oscillation", arguments, 1.1 * duration + 1.0)


def _driven_by_torque(percent: float, ramp: float, limit: float, duration: float) -> "Excitation":
    from achse.cli.axes.excitation import Excitation
    from achse.motion.states import TorqueStartType

    arguments = (
        TorqueStartType.ABSOLUTE, 0, 0, 0, percent * PER_PERCENT, ramp * PER_PERCENT,
        limit, -limit, 0.0, 0.0, 0.0,
    )  # fmt: skip
    return Excitation("start_torque_control", arguments, duration)


async def _carry_out(
    client: "Client",
    name: str,
    excitation: "Excitation",
    sample_time: float,
    plot: bool | None,
    in_json: bool,
) -> None:
    """Excite the axis, stop it when the time is over, follow it to standstill, and report."""
    from achse.cli.axes.move import follow
    from achse.cli.axes.nc import chosen

    [item] = await chosen(client, [name])
    course = await follow(item, excitation, sample_time)
    if in_json:
        print_json(_as_json(item, excitation, course))
    else:
        draw(course, on_terminal() if plot is None else plot)
        print(_sentence(item, course))
    if course.trouble is not None:
        fail(course.trouble)


def _sentence(item: "NcAxis", course: "Course") -> str:
    trace, unit = course.trace, item.unit
    lowest, highest = (decimal(end(trace["actual_position"]), 3) for end in (min, max))
    return (
        f"{item}: {lowest} … {highest} {unit} in {course.seconds:.3f} s,"
        f" peak velocity {decimal(trace.peak('actual_velocity'), 2)} {unit}/s,"
        f" peak following error {decimal(trace.peak('following_error'))} {unit},"
        f" at rest at {decimal(trace['actual_position'][-1], 3)} {unit}"
    )


def _as_json(item: "NcAxis", excitation: "Excitation", course: "Course") -> dict[str, Any]:
    trace = course.trace
    return {
        "id": item.axis_id,
        "name": item.name,
        "unit": item.unit,
        "function": excitation.function,
        "done": course.trouble is None,
        "trouble": course.trouble,
        "lowest": min(trace["actual_position"]),
        "highest": max(trace["actual_position"]),
        "end": trace["actual_position"][-1],
        "seconds": course.seconds,
        "peak_velocity": trace.peak("actual_velocity"),
        "peak_following_error": trace.peak("following_error"),
        "trace": {"time": trace.times, **trace.columns},
    }
