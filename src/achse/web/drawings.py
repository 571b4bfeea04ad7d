"""Drawn bodies in the browser: rungs, boxes and charts, with values of the running PLC."""

from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from typing import Any, NamedTuple

from achse.ams import AdsError
from achse.st.graphical.body import GraphicalBody
from achse.st.graphical.lowering import picture
from achse.st.graphical.pictures import no_value
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.units import Program, Unit
from achse.web.watched import WatchedTarget


class DrawnBody(NamedTuple):
    """A body in a graphical language."""

    name: str
    """`MAIN`, `MAIN.Act`."""
    instance: str
    """Prefix of its variables in the running PLC; empty for blocks of which none is chosen."""
    body: GraphicalBody

    @property
    def operands(self) -> list[str]:
        """Texts of the operands in the drawing, each once."""
        operands: dict[str, None] = {}
        try:
            picture(self.body, operands.setdefault)
        except Unexpected:
            return []
        return list(operands)


def drawn_bodies(units: Iterable[Unit], instance: str = "") -> list[DrawnBody]:
    """Return the drawn bodies of some units; `instance` is the block whose values are shown."""
    bodies = []
    for unit in units:
        owner = instance or (unit.name if isinstance(unit, Program) else "")
        for name, tree in _parts(unit):
            body = getattr(tree, "body", None)
            if isinstance(body, GraphicalBody):
                bodies.append(DrawnBody(name, owner, body))
    return bodies


def _parts(unit: Unit) -> Iterator[tuple[str, Any]]:
    yield unit.name, unit
    for part in getattr(unit, "parts", ()):
        yield f"{unit.name}.{part.name}", part
        for accessor in ("get", "set"):
            yield f"{unit.name}.{part.name}.{accessor.title()}", getattr(part, accessor, None)


def shown(drawn: DrawnBody, values: Mapping[str, object]) -> dict[str, Any]:
    """Return a body as a page shows it: lines of text, in which lines with power are double."""
    try:
        lines = picture(drawn.body, values.get if values else no_value)
    except Unexpected as fault:
        lines = [f"cannot be drawn: {fault.message}"]
    return {"name": drawn.name, "language": drawn.body.language, "lines": lines}


async def operand_values(
    watched: WatchedTarget, port: int, drawn: DrawnBody
) -> dict[str, object | None]:
    """Return the values of the operands of a body that are variables, its own before others."""
    if not drawn.instance:
        return {}
    device = watched.device(port)
    texts = drawn.operands
    own = {text: f"{drawn.instance}.{text}" for text in texts}
    answers = await device.read_many([*own.values(), *texts], strict=False)
    values: dict[str, object | None] = {}
    for text in texts:
        for name in (own[text], text):
            value = answers.get(name)
            if value is not None and not isinstance(value, AdsError):
                values[text] = value.name if isinstance(value, Enum) else value
                break
    return values
