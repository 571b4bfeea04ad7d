"""`achse ads raw` reads and writes by index group and offset."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.output import hex_dump, print_json
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.iec import IecType

PLC_PORT = 851


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    client_command(app, PLC_PORT, signed=True)(raw)


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


def _type(name: str) -> "IecType[Any]":
    from achse.iec import DeclarationError
    from achse.iec.names import parse_type

    try:
        return parse_type(name)
    except DeclarationError as fault:
        raise typer.BadParameter(str(fault), param_hint="--type") from None


def _data(text: str, type_name: str | None) -> bytes:
    """Return the bytes of hex digits, or of a literal of that type."""
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
        from achse.iec.documents import as_json, as_text

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


async def raw(
    client: "Client",
    group: Group,
    offset: Offset,
    data: Annotated[
        str | None,
        typer.Argument(help="Write this: hex digits, or a literal of --type.", show_default="read"),
    ] = None,
    type: Annotated[
        str | None,
        typer.Option("--type", "-t", help="IEC type: LREAL, STRING(80), ARRAY [0..2] OF INT."),
    ] = None,
    length: Annotated[
        int | None,
        typer.Option("--length", "-l", min=0, help="Bytes to read.", show_default=False),
    ] = None,
    answer: Annotated[
        str | None,
        typer.Option(help="With DATA: IEC type of the answer.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """Read or write by index group and offset: bytes, or a value of a type.

    With DATA and --answer or --length, both are one request (ReadWrite).
    """
    if data is None:
        if answer is not None:
            raise typer.BadParameter("--answer goes with DATA; without it --type is the answer's")
        _show(await client.read_raw(group, offset, _length(length, type)), type, in_json)
        return
    content = _data(data, type)
    if answer is not None or length is not None:
        read = await client.read_write_raw(group, offset, _length(length, answer), content)
        _show(read, answer, in_json)
        return
    await client.write_raw(group, offset, content)
    if in_json:
        print_json({"written": len(content)})
