"""`achse plc draw` shows drawn bodies of a PLC as text, with values of a running station."""

from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.options import Plc, Sources
from achse.cli.output import print_json
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.client import Client
    from achse.st.graphical.body import GraphicalBody
    from achse.st.syntax.parser import Parsed

_NO_BODY = "has no drawn body: expected one in LD, FBD, IL, SFC or CFC"


async def draw(
    client: "Client | None",
    sources: Sources,
    unit: Annotated[
        str,
        typer.Argument(help="A program, block or function, or UNIT.ACTION.", show_default=False),
    ],
    live: Annotated[
        bool, typer.Option("--live", help="With the values of a running station.")
    ] = False,
    of: Annotated[
        str,
        typer.Option(help="Instance of a function block, MAIN.fbX.", show_default="the program"),
    ] = "",
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Draw a body in a graphical language: rungs, boxes, charts, and with --live their values.

    Lines with power are double, active steps have a star.
    """
    from achse.st.files.files import read_sources
    from achse.st.graphical.lowering import picture
    from achse.st.graphical.pictures import OperandValue, no_value
    from achse.st.lexis.source import SourceError
    from achse.st.syntax.cursor import Unexpected

    try:
        parsed, _ = read_sources(sources, (), [])
    except SourceError as error:
        fail(str(error))
    body, is_program = _body(parsed, unit)
    try:
        value: OperandValue = no_value
        if live and client is not None:
            if not of and not is_program:
                fail(f"{unit} is a block: name an instance by --of, as MAIN.fbX")
            pending: dict[str, object] = {}
            picture(body, lambda text: pending.setdefault(text, None))
            values = await _values(client, plc, of or unit.partition(".")[0], list(pending))
            value = values.get
        lines = picture(body, value)
    except Unexpected as fault:
        fail(f"{unit} cannot be drawn: {fault.message}")
    if in_json:
        print_json({"unit": unit, "language": body.language, "lines": lines})
    else:
        print("\n".join(lines))


def _body(sources: "list[Parsed]", name: str) -> "tuple[GraphicalBody, bool]":
    """Return the drawn body of a name, and True if it is that of a program."""
    from achse.st.graphical.body import GraphicalBody
    from achse.st.syntax.units import Program

    key, _, part = name.lower().partition(".")
    units = [one for parsed in sources for one in parsed.units if one.name.lower() == key]
    if not units:
        fail(f"no unit is named {name}")
    owners = [one for one in getattr(units[0], "parts", ()) if one.name.lower() == part]
    body = getattr((owners if part else units)[0], "body", None) if owners or not part else None
    if not isinstance(body, GraphicalBody):
        fail(f"{name} {_NO_BODY}")
    return body, isinstance(units[0], Program)


async def _values(
    client: "Client", plc: int, owner: str, texts: list[str]
) -> dict[str, object | None]:
    """Values of expressions inside of an instance or program, else of global ones."""
    from achse.dap.link import DebugLink, DebugRefused

    link = DebugLink(client, plc)
    values: dict[str, object | None] = {}
    for text in texts:
        for expression in (f"{owner}.{text}", text):
            try:
                answer = await link.request("evaluate", expression=expression, call=0)
            except DebugRefused:
                continue
            values[text] = {"TRUE": True, "FALSE": False}.get(answer["value"], answer["value"])
            break
    return values
