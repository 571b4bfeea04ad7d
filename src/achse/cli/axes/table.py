"""`achse table`: cam tables and motion functions of an NC, or in files."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli import complete
from achse.cli.axes.axis import NC_PORT
from achse.cli.axes.gear import Joined, JoinedBy
from achse.cli.failure import fail
from achse.cli.options import Cyclic
from achse.cli.output import on_terminal, print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.axes.table_curve import Curve, SlaveLimits, Violation
    from achse.cli.axes.table_files import Content
    from achse.client import Client

table = typer.Typer(no_args_is_help=True, help="Cam tables and motion functions of an NC.")

TableId = Annotated[int, typer.Argument(metavar="TABLE", min=1, max=4095, help="Its id.")]
Limit = float | None
LimitOption = Annotated[Limit, typer.Option(help="Limit of the slave.", show_default=False)]


def _offline(options: dict[str, Any]) -> bool:
    """Return True if the command reads a file, not an axis."""
    return not options["source"].isdecimal() and not options["axis"]


@client_command(table, NC_PORT)
async def show(
    client: "Client",
    number: Annotated[
        int | None,
        typer.Argument(
            metavar="[TABLE]", min=1, max=4095, help="Its id.", show_default="list the tables"
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write its rows there (CSV).", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """List the tables of the NC, show the rows or points of one, or write them to a file."""
    if number is None:
        if to is not None:
            raise typer.BadParameter("--to writes one table: which?", param_hint="TABLE")
        await _list(client, in_json)
    elif to is None:
        await _show(client, number, in_json)
    else:
        await _write(client, number, to, in_json)


async def _list(client: "Client", in_json: bool) -> None:
    """Print the tables of the NC, a line each."""
    facts = [await each.facts() for each in await client.nc.tables()]
    if in_json:
        print_json([_facts_json(each) for each in facts])
    elif facts:
        rows = [
            (
                str(each.id),
                each.name,
                _words(each.kind.name),
                "cyclic" if each.cyclic else "linear",
                f"{each.rows} rows",
                f"{each.users} users",
            )
            for each in facts
        ]
        print_table(rows, right=frozenset({0, 4}))


def _words(name: str) -> str:
    return name.lower().replace("_", " ")


def _facts_json(facts: Any) -> dict[str, Any]:
    return {
        "id": facts.id,
        "name": facts.name,
        "kind": _words(facts.kind.name),
        "cyclic": facts.cyclic,
        "rows": facts.rows,
        "columns": facts.columns,
        "users": facts.users,
    }


async def _content(client: "Client", table_id: int) -> "Content":
    from achse.client.nc import TableKind

    remote = client.nc.table(table_id)
    facts = await remote.facts()
    if facts.kind == TableKind.MOTION_FUNCTION:
        return await remote.read_points()
    return [(row[0], row[-1] if len(row) == 1 else row[1]) for row in await remote.read_rows()]


async def _show(client: "Client", number: int, in_json: bool) -> None:
    """Print the facts of a table, and its rows or points."""
    from achse.client.nc import FunctionPoint
    from achse.motion.tables.text import NAMES

    facts = await client.nc.table(number).facts()
    content = await _content(client, number)
    if in_json:
        rows = [
            dict(zip(NAMES, each, strict=False))
            if isinstance(each, FunctionPoint)
            else {"master": each[0], "slave": each[1]}
            for each in content
        ]
        print_json({**_facts_json(facts), "content": rows})
        return
    kind = "cyclic" if facts.cyclic else "linear"
    print(f"{facts.id} {facts.name}: {kind} {_words(facts.kind.name)}, {facts.users} users")
    print_table(
        [NAMES[: len(NAMES) if isinstance(content[0], FunctionPoint) else 2]]
        + [tuple(f"{number:.10g}" for number in each) for each in content],
        right=frozenset(range(len(NAMES))),
    )


@client_command(table, NC_PORT, "import")
async def import_table(
    client: "Client",
    number: TableId,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Rows with commas or blanks.")],
    cyclic: Cyclic = False,
    replace: Annotated[
        bool, typer.Option("--replace", help="Forget a table with that id first.")
    ] = False,
    in_json: Json = False,
) -> None:
    """Make a table of a file: master and slave positions, or points of a motion function."""
    from achse.ams import DeviceError
    from achse.cli.axes.table_files import read_table
    from achse.client.nc import FunctionPoint, TableKind
    from achse.codes import NcError

    content = read_table(file)
    points = [each for each in content if isinstance(each, FunctionPoint)]
    remote = client.nc.table(number)
    if replace:
        try:
            await remote.delete()
        except DeviceError as refusal:
            if refusal.code != NcError.TABLE_ID.number:
                raise
    kind = TableKind.MOTION_FUNCTION if points else TableKind.CAM
    await remote.create(len(content), kind=kind, cyclic=cyclic)
    try:
        if points:
            await remote.write_points(points)
        else:
            await remote.write_rows([row[:2] for row in content])
        await remote.check()
    except BaseException:
        await remote.delete()
        raise
    facts = await remote.facts()
    if in_json:
        print_json(_facts_json(facts))
    else:
        print(f"table {number}: {_words(kind.name)}, {facts.rows} rows")


async def _write(client: "Client", number: int, file: Path, in_json: bool) -> None:
    """Write the rows or points of a table to a file."""
    from achse.cli.axes.table_files import written
    from achse.cli.files import write_file

    content = await _content(client, number)
    write_file(file, written(content).encode())
    if in_json:
        print_json({"id": number, "file": str(file), "rows": len(content)})
    else:
        print(f"{file}: {len(content)} rows")


@client_command(table, NC_PORT, alone=_offline)
async def check(
    client: "Client | None",
    source: Annotated[
        str,
        typer.Argument(metavar="TABLE", help="Id of a table of the NC, or a file with its rows."),
    ],
    joined: JoinedBy = Joined.SPLINE,
    cyclic: Cyclic = False,
    master_velocity: Annotated[
        float, typer.Option("--master-velocity", "-v", min=0, help="Units of the master/s.")
    ] = 1.0,
    axis: Annotated[
        str | None,
        typer.Option(
            help="Its soft limits, maximum velocity and acceleration, default jerk.",
            autocompletion=complete.axes,
            show_default=False,
        ),
    ] = None,
    min_position: LimitOption = None,
    max_position: LimitOption = None,
    max_velocity: LimitOption = None,
    max_acceleration: LimitOption = None,
    max_jerk: LimitOption = None,
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw it; with --json all samples of the curves.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(help="Draw it to a file: .svg, .png or .pdf.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """Check what a table demands of its slave: position, velocity, acceleration, jerk.

    Exit code 1 if it breaks a limit.
    """
    curve = await _curve(client, source, joined, cyclic, master_velocity)
    own = min_position, max_position, max_velocity, max_acceleration, max_jerk
    limits, unit = await _limits(client, axis, own)
    broken = curve.violations(limits)
    if out is not None:
        curve.save(out, limits, unit, f"table {source}")
    if in_json:
        print_json(_curve_json(curve, broken, samples=plot))
    elif plot:
        from rich.console import Console

        console = Console(highlight=False)
        console.print(curve.text(limits, unit, min(console.width, 100) if on_terminal() else 80))
    else:
        from achse.cli.axes.table_curve import QUANTITIES

        for name, (least, most) in zip(QUANTITIES, curve.extremes, strict=True):
            print(f"{name:<13} {least:>14.6g} … {most:<14.6g}".rstrip())
    if not in_json:
        if out is not None:
            print(out)
        _report(broken, unit)
    if broken:
        raise typer.Exit(1)


def _report(broken: "list[Violation]", unit: str) -> None:
    """Print each limit that is broken, in a sentence."""
    for each in broken:
        places = ", ".join(f"{begin:.6g}…{end:.6g}" for begin, end in each.spans[:3])
        where = f", at master {places}" if places else ""
        more = " …" if len(each.spans) > 3 else ""
        print(f"{each.quantity} {each.value:.6g} is beyond its limit {each.limit:g}{where}{more}")


def _curve_json(curve: "Curve", broken: "list[Violation]", samples: bool) -> dict[str, Any]:
    from achse.cli.axes.table_curve import QUANTITIES

    document: dict[str, Any] = {
        "master_velocity": curve.master_velocity,
        "extremes": {
            name: {"least": least, "most": most}
            for name, (least, most) in zip(QUANTITIES, curve.extremes, strict=True)
        },
        "violations": [
            {
                "quantity": each.quantity,
                "value": each.value,
                "limit": each.limit,
                "master": each.spans,
            }
            for each in broken
        ],
        "ok": not broken,
    }
    if samples:
        document["master"] = curve.master
        document |= dict(zip(QUANTITIES, curve.values, strict=True))
    return document


async def _curve(
    client: "Client | None", source: str, joined: Joined, cyclic: bool, velocity: float
) -> "Curve":
    from achse.cli.axes.table_curve import curve_of
    from achse.cli.axes.table_files import read_table
    from achse.motion.states import CamInterpolation

    if source.isdecimal():
        assert client is not None
        if not 1 <= int(source) <= 4095:
            fail(f"table {source}, expected 1..4095", name="INVALID_ID")
        content = await _content(client, int(source))
        cyclic = (await client.nc.table(int(source)).facts()).cyclic
    else:
        content = read_table(Path(source))
    joins = dict(zip(Joined, CamInterpolation, strict=True))
    few = len(content) < 3 and joined is Joined.SPLINE
    return curve_of(content, joins[Joined.LINEAR if few else joined], cyclic, velocity)


async def _limits(
    client: "Client | None", name: str | None, own: tuple[Limit, ...]
) -> "tuple[SlaveLimits, str]":
    """SlaveLimits of an axis, those given on the command line first; and its unit."""
    from achse.cli.axes.table_curve import SlaveLimits

    if name is None:
        return SlaveLimits(*own), ""
    assert client is not None
    from achse.cli.axes.nc import chosen

    [item] = await chosen(client, [name])
    parameters = item.remote.parameters
    ends: list[Limit] = []
    for end in ("min", "max"):
        on = await parameters[f"encoder_soft_limit_{end}_enable"]
        ends.append(await parameters[f"encoder_soft_limit_{end}"] if on else None)
    theirs = [
        *ends,
        await parameters["max_velocity"],
        await parameters["max_acceleration"],
        await parameters["default_jerk"],
    ]
    both = zip(own, theirs, strict=True)
    return SlaveLimits(*(its if mine is None else mine for mine, its in both)), item.unit
