"""`achse drive objects`: the object dictionary of the drive, without a drive."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import Json
from achse.site.objects import access_text, object_cells, pdo_text

if TYPE_CHECKING:
    from achse.drive.objects import ObjectRow

_DIGITS = 4
"""Hexadecimal digits of an index."""

_SHOWN = 3
_SHORTEST = 3
"""Hexadecimal digits that are looked for as part of a name, too: `dec`."""


def register(drive: typer.Typer) -> None:
    """Put the command beside those of `achse drive`."""
    drive.command()(objects)


def objects(
    wanted: Annotated[
        str | None,
        typer.Argument(
            metavar="[INDEX[:SUB]]",
            help="Objects whose index begins so, 60 or 1C1, or with this in their name; of one"
            " object all facts: 6041, 0x1C32:02, Statusword.",
            show_default=False,
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """List the object dictionary, one line per entry, or show all facts of one object."""
    from achse.drive.objects import ROWS

    rows = _one_object(wanted) if wanted else []
    if rows and not in_json:
        for number, row in enumerate(rows):
            if number:
                print()
            facts = _facts(row).items()
            print_table([(name, _cell(value)) for name, value in facts if value not in ("", [])])
        return
    rows = rows or _beginning(wanted or "", ROWS)
    if in_json:
        print_json([_facts(row) for row in rows])
        return
    lines = [("index", "type", "access", "pdo", "default", "unit", "name")]
    lines += [object_cells(row) for row in rows]
    print_table(lines, right=frozenset({4}))


def _one_object(text: str) -> "list[ObjectRow]":
    """Return the entries of one object, or one entry; empty if the text names several or none."""
    from achse.drive.objects import ROWS

    index, colon, _ = text.partition(":")
    digits = _digits(index)
    if digits is None:
        folded = _folded(text)
        named = [row for row in ROWS if folded == _folded(row.name)]
        return named[:1] or [row for row in ROWS if folded == _folded(row.name.partition(":")[0])]
    if not colon and len(digits) < _DIGITS:
        return []
    number, entry = entry_of(text)
    rows = [row for row in ROWS if row.index == number and entry in (None, row.subindex)]
    if not rows:
        fail(f"the drive has no {text}; see `achse drive objects`")
    return rows


def _beginning(wanted: str, every: "Sequence[ObjectRow]") -> "list[ObjectRow]":
    """Return the rows whose index begins so, or whose name has it; ends the command without any."""
    from achse.iec.nearest import did_you_mean

    prefix = _digits(wanted)
    rows = [row for row in every if prefix is not None and f"{row.index:04X}".startswith(prefix)]
    if not rows and (prefix is None or len(prefix) >= _SHORTEST):
        rows = [row for row in every if _folded(wanted) in _folded(row.name)]
    if not rows:
        hint = did_you_mean(wanted, _names(every)) or "; see `achse drive objects`"
        fail(f"no object's index begins with {wanted!r}, and no name has it{hint}")
    return rows


def entry_of(text: str) -> tuple[int, int | None]:
    """Index and subindex of INDEX, INDEX:SUB or a name; typer's complaint if it is none of them."""
    index, colon, subindex = text.partition(":")
    if _digits(index) is None and text:
        return _named(text)
    return _number(index, 0xFFFF, text), _number(subindex, 0xFF, text) if colon else None


def _named(text: str) -> tuple[int, int | None]:
    """Return the entry, or the whole object, of that name."""
    from achse.drive.objects import ROWS
    from achse.iec.nearest import did_you_mean

    wanted = _folded(text)
    for row in ROWS:
        if wanted == _folded(row.name):
            return row.index, row.subindex
        if wanted == _folded(row.name.partition(":")[0]):
            return row.index, None
    names = _names(ROWS)
    inside = [name for name in names if wanted and wanted in _folded(name)][:_SHOWN]
    hint = f"; did you mean {' or '.join(map(repr, inside))}?" if inside else None
    raise typer.BadParameter(
        "INDEX or INDEX:SUB in hexadecimal expected, or a name as in `achse drive objects`, got"
        f" {text!r}{hint or did_you_mean(text, names)}"
    )


def _names(rows: "Iterable[ObjectRow]") -> list[str]:
    """Return the names of the objects, and of the entries of records."""
    return list(
        dict.fromkeys(name for row in rows for name in (row.name.partition(":")[0], row.name))
    )


def _folded(name: str) -> str:
    """Return a name without case, spaces and the like."""
    return "".join(sign for sign in name.casefold() if sign.isalnum())


def _digits(text: str) -> str | None:
    """Hexadecimal digits, with 0x before or h behind allowed; None for other texts."""
    digits = text.upper().removeprefix("0X").removesuffix("H")
    if text and (not digits or set(digits) - set("0123456789ABCDEF")):
        return None
    return digits


def _number(text: str, most: int, entry: str) -> int:
    digits = _digits(text)
    if not digits or int(digits, 16) > most:
        raise typer.BadParameter(f"INDEX or INDEX:SUB in hexadecimal expected, got {entry!r}")
    return int(digits, 16)


def _facts(row: "ObjectRow") -> dict[str, Any]:
    return {
        "index": f"0x{row.index:04X}",
        "subindex": row.subindex,
        "name": row.name,
        "type": row.type.name,
        "access": access_text(row),
        "pdo": pdo_text(row).split(),
        "default": row.default,
        "minimum": row.least,
        "maximum": row.most,
        "values": list(row.values),
        "unit": row.unit,
        "modes": row.modes,
        "stored": row.stored,
        "after_restart": row.restart,
        "meaning": row.doc,
    }


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return " ".join(map(str, value)) if isinstance(value, list) else str(value)
