"""`achse ads raw` reads and writes by index group and offset."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.output import as_json, as_text, hex_dump, print_json
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.iec import IecType

__all__ = ["raw"]

PLC_PORT = 851

raw = typer.Typer(no_args_is_help=True, help="Read and write by index group and offset.")


def _number(text: str) -> int:
    """`16448`, `0x4040`, `16#4040`; UINT32."""
    try:
        number = int(text.lower().replace("16#", "0x"), 0)
    except ValueError:
        number = -1
    if not 0 <= number <= 0xFFFF_FFFF:
        raise typer.BadParameter(f"a number 0..0xFFFFFFFF like 16448 or 0x4040, got {text!r}")
    return number


def _bytes(text: str) -> bytes:
    try:
        return bytes.fromhex(text.lower().removeprefix("0x"))
    except ValueError:
        raise typer.BadParameter(
            f"pairs of hexadecimal digits like '01 ff', or a value with its type; got {text!r}"
        ) from None


Group = Annotated[int, typer.Argument(parser=_number, metavar="GROUP")]
Offset = Annotated[int, typer.Argument(parser=_number, metavar="OFFSET")]
Length = Annotated[
    int | None, typer.Option("--length", "-l", min=0, help="Bytes to ask for.", show_default=False)
]
Type = Annotated[
    str | None,
    typer.Option("--type", "-t", help="IEC type: LREAL, STRING(80), ARRAY [0..2] OF INT."),
]


def _type(name: str) -> "IecType[Any]":
    from achse.iec import DeclarationError
    from achse.iec.names import parse_type

    try:
        return parse_type(name)
    except DeclarationError as fault:
        raise typer.BadParameter(str(fault), param_hint="--type") from None


def _data(text: str, type_name: str | None) -> bytes:
    """The bytes of hex digits, or of a literal of that type."""
    if type_name is None:
        return _bytes(text)
    from achse.iec import IecValueError
    from achse.iec.literals import parse_value

    type = _type(type_name)
    try:
        return type.encode(parse_value(type, text))
    except IecValueError as fault:
        raise typer.BadParameter(str(fault), param_hint="DATA") from None


def _show(data: bytes, type_name: str | None, in_json: bool) -> None:
    value = text = None
    if type_name is not None:
        from achse.ams import DecodeError
        from achse.iec import IecDecodeError

        type = _type(type_name)
        try:
            value = type.decode(data)
        except IecDecodeError as fault:
            raise DecodeError(str(fault)) from None
        value, text = as_json(type, value), as_text(type, value)
    if in_json:
        print_json({"data": data.hex(), "value": value})
    elif text is not None:
        print(text)
    elif len(data) <= 16:
        print(data.hex(" "))
    else:
        print("\n".join(hex_dump(data)))


def _length(length: int | None, type_name: str | None) -> int:
    if length is not None:
        return length
    if type_name is None:
        raise typer.BadParameter("how many bytes? give --length or --type")
    return _type(type_name).size


@client_command(raw, PLC_PORT)
async def read(
    client: "Client",
    group: Group,
    offset: Offset,
    type: Type = None,
    length: Length = None,
    in_json: Json = False,
) -> None:
    """Read bytes, or a value of a type."""
    data = await client.read_raw(group, offset, _length(length, type))
    _show(data, type, in_json)


@client_command(raw, PLC_PORT, signed=True)
async def write(
    client: "Client",
    group: Group,
    offset: Offset,
    data: Annotated[str, typer.Argument(help="Hex digits, or a literal of the type.")] = "",
    type: Type = None,
    in_json: Json = False,
) -> None:
    """Write bytes, or a value of a type."""
    content = _data(data, type)
    await client.write_raw(group, offset, content)
    if in_json:
        print_json({"written": len(content)})


@client_command(raw, PLC_PORT, signed=True)
async def readwrite(
    client: "Client",
    group: Group,
    offset: Offset,
    data: Annotated[str, typer.Argument(help="Hex digits, or a literal of --write-type.")] = "",
    type: Type = None,
    length: Length = None,
    write_type: Annotated[
        str | None, typer.Option(help="IEC type of what is written.", show_default=False)
    ] = None,
    in_json: Json = False,
) -> None:
    """Write and read in one request."""
    content = _data(data, write_type)
    answer = await client.read_write_raw(group, offset, _length(length, type), content)
    _show(answer, type, in_json)
