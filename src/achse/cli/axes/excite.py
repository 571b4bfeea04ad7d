"""`achse axis jog`, `reverse`, `sine` and `torque` excite an axis for a time, and follow it."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.axes.axis import NC_PORT, AxisName, Plot, SampleTime, Velocity, draw
from achse.cli.failure import fail
from achse.cli.output import decimal, on_terminal, print_json
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.axes.excitation import Excitation
    from achse.cli.axes.move import Course
    from achse.cli.axes.nc import NcAxis
    from achse.client import Client

__all__ = ["register"]

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
    client_command(app, NC_PORT)(reverse)
    client_command(app, NC_PORT)(sine)
    client_command(app, NC_PORT, signed=True)(torque)


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
    """Travel at a manual velocity, as long as a key would be held; Ctrl-C lets it go earlier."""
    from achse.cli.axes.excitation import Excitation
    from achse.codes.axis import JogType

    start_type = JogType[speed.name] + negative  # the other direction is one more
    excitation = Excitation("start", (start_type, 0.0, 0.0), duration)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


async def reverse(
    client: "Client",
    name: AxisName,
    velocity: Velocity,
    between: Annotated[
        tuple[float, float], typer.Option(metavar="POSITION POSITION", help="The two targets.")
    ],
    pause: Annotated[float, typer.Option(min=0.0, help="At each target, s.")] = 0.0,
    duration: Duration = 5.0,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Move an axis to and fro; Ctrl-C stops it earlier."""
    from achse.cli.axes.excitation import Excitation

    excitation = Excitation("start_reversing_positioning", (1, *between, velocity, pause), duration)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


async def sine(
    client: "Client",
    name: AxisName,
    amplitude: Annotated[float, typer.Option(help="Of the velocity, units/s.")],
    frequency: Annotated[float, typer.Option(max=10.0, help="Hz.")],
    sweep: Annotated[
        tuple[float, float],
        typer.Option(
            metavar="HZ HZ",
            help="A second sine goes through these frequencies.",
            show_default=False,
        ),
    ] = (1.0, 1.0),
    signal: Annotated[float, typer.Option(help="Velocity amplitude of the second, units/s.")] = 0.0,
    duration: Duration = 5.0,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Let an axis swing; Ctrl-C stops it earlier."""
    from achse.cli.axes.excitation import Excitation

    count = FREQUENCIES if signal else 1
    arguments = (
        1, amplitude, frequency, signal, 1.0, *sweep, duration / count, count, 1,
    )  # fmt: skip
    # a little longer than it takes, so that it ends by itself
    excitation = Excitation("start_sine_oscillation", arguments, 1.1 * duration + 1.0)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


async def torque(
    client: "Client",
    name: AxisName,
    percent: Annotated[float, typer.Argument(help="Of the rated torque, signed.")],
    limit: Annotated[float, typer.Option(help="Velocity that it keeps to, units/s.")],
    ramp: Annotated[float, typer.Option(min=0.0, help="%/s; 0 = at once.")] = 0.0,
    duration: Duration = 5.0,
    plot: Plot = None,
    sample_time: SampleTime = 0.01,
    in_json: Json = False,
) -> None:
    """Drive an axis by its torque, then stop it in position control."""
    from achse.cli.axes.excitation import Excitation
    from achse.motion.states import TorqueStartType

    arguments = (
        TorqueStartType.ABSOLUTE, 0, 0, 0, percent * PER_PERCENT, ramp * PER_PERCENT,
        limit, -limit, 0.0, 0.0, 0.0,
    )  # fmt: skip
    excitation = Excitation("start_torque_control", arguments, duration)
    await _carry_out(client, name, excitation, sample_time, plot, in_json)


async def _carry_out(
    client: "Client",
    name: str,
    excitation: "Excitation",
    sample_time: float,
    plot: bool | None,
    in_json: bool,
) -> None:
    """Excite the axis, stop it when the time is over, follow it to its rest, and tell."""
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
