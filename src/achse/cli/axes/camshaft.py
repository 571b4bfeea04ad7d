"""`achse camshaft` shows the camshaft controllers of a station and what their cams switch."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.options import Count, CycleTime, Watch
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client

CAMSHAFT_PORT = 900

_FIRST_WORD = ".configured_cams"
"""Each controller has one symbol with this ending: how its name is found."""

camshaft = typer.Typer(no_args_is_help=True, help="Show camshaft controllers and their cams.")


async def _list(client: "Client", in_json: bool) -> None:
    """Print the controllers: angle, stroke rate, cams, tracks that are on, errors."""
    states = [await _state(client, name) for name in await _names(client)]
    if in_json:
        print_json(states)
        return
    print_table(
        [
            ("name", "degrees", "1/min", "cams", "tracks on", "errors"),
            *(
                (
                    *(each["name"], f"{each['angle'] / 10:.1f}", str(each["actual_rate"])),
                    *(str(each["configured_cams"]), _tracks(each["cams"])),
                    " ".join(each["errors"]) or "none",
                )
                for each in states
            ),
        ],
        right=frozenset((1, 2, 3)),
    )


@client_command(camshaft, CAMSHAFT_PORT, endless=lambda options: bool(options["watch"]))
async def show(
    client: "Client",
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]", help="The controller.", show_default="list the controllers"
        ),
    ] = None,
    watch: Watch = False,
    cycle_time: CycleTime = 0.01,
    count: Count = None,
    in_json: Json = False,
) -> None:
    """List the controllers, or show all values of one, and its cams that have a type.

    With --watch each change of the tracks of a controller, the first one without NAME, is a line.
    """
    from achse.camshaft.parameters import (
        CAM_PARAMETERS,
        CAMS,
        CONTROLLER_PARAMETERS,
        ENCODER_PARAMETERS,
        CamType,
    )

    if watch:
        await _watch(client, await _chosen(client, name), cycle_time, count, in_json)
        return
    if name is None:
        await _list(client, in_json)
        return
    name = await _chosen(client, name)
    own = {f"{name}.{each.name}": each for each in CONTROLLER_PARAMETERS}
    own |= {f"{name}.Encoder.{each.name}": each for each in ENCODER_PARAMETERS}
    values = {own[key].name: int(value) for key, value in (await client.read_many(own)).items()}
    types = await client.read_many(f"{name}.Cam{n}.type" for n in range(1, CAMS + 1))
    cams = []
    for number, kind in enumerate(types.values(), 1):
        if kind:
            keys = [f"{name}.Cam{number}.{each.name}" for each in CAM_PARAMETERS]
            read = (await client.read_many(keys)).values()
            names = (each.name for each in CAM_PARAMETERS)
            cams.append({"number": number} | dict(zip(names, map(int, read), strict=True)))
    if in_json:
        print_json({**await _state(client, name), "parameters": values, "cam": cams})
        return
    units = {each.name: each.unit for each in own.values()}
    print_table([(key, str(value), units[key]) for key, value in values.items()])
    for cam in cams:
        kind = CamType(cam["type"]).name.lower()
        flags = [
            flag
            for flag in ("forward", "backward", "dynamic", "hysteresis_on", "force")
            if cam[flag]
        ]
        print(
            f"cam {cam['number']}: {kind} on track {cam['track']},"
            f" {cam['start']}..{cam['end']} degrees, {' '.join(flags)}"
        )


async def _watch(
    client: "Client", name: str, cycle_time: float, count: int | None, in_json: bool
) -> None:
    """Print a line for each change of the tracks."""
    async with client.subscribe(f"{name}.Outputs.cams", cycle_time=cycle_time) as samples:
        seen = 0
        async for sample in samples:
            bits = int(sample.value)
            if in_json:
                print_json({"time": sample.time.isoformat(), "name": name, "cams": bits})
            else:
                stamp = f"{sample.time.astimezone():%H:%M:%S.%f}"[:-3]
                print(f"{stamp}  {name}  {_tracks(bits)}", flush=True)
            seen += 1
            if seen == count:
                return


async def _names(client: "Client") -> list[str]:
    """Return the controllers, in their order."""
    return [
        entry.name.removesuffix(_FIRST_WORD)
        for entry in sorted(await client.symbols(), key=lambda entry: entry.index_group)
        if entry.name.endswith(_FIRST_WORD) and not entry.name.endswith(".Outputs" + _FIRST_WORD)
    ]


async def _chosen(client: "Client", name: str | None) -> str:
    """Return the name as the station has it."""
    names = await _names(client)
    if name is None:
        return names[0]
    match = next((each for each in names if each.casefold() == name.casefold()), None)
    if match is None:
        from achse.iec.nearest import did_you_mean

        fail(f"no camshaft {name!r}, there are {', '.join(names)}{did_you_mean(name, names)}")
    return match


async def _state(client: "Client", name: str) -> dict[str, Any]:
    """Read the state of a controller."""
    words = (
        *("raw", "angle", "actual_rate", "configured_cams", "cams"),
        *("io_errors", "encoder_error", "shaft_error", "rate_error"),
    )
    read = (await client.read_many(f"{name}.Outputs.{word}" for word in words)).values()
    values = dict(zip(words, map(int, read), strict=True))
    errors = [word for word in words if "error" in word and values.pop(word)]
    return {"name": name, **values, "errors": errors}


def _tracks(bits: int) -> str:
    return " ".join(str(track) for track in range(bits.bit_length()) if bits >> track & 1) or "-"
