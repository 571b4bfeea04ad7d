"""Building the machine code of a project, or taking it from the user's cache.

The cache is keyed by all that the typed form follows from (`achse.st.check.origin`), the types and
places of all variables, and our own code from the parser to the back end.
"""

import hashlib
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from pathlib import Path

from achse.native.backend import Effort, ObjectCache, compile_module, identity
from achse.plc.lowering.placement import Placement
from achse.plc.machine.module import ProjectTranslator
from achse.plc.memory import Area
from achse.plc.program import PlacedVariable
from achse.st.typed.project import TypedProject

__all__ = ["machine_code"]

_NAME = "structured-text"


def machine_code(
    project: TypedProject,
    placement: Placement,
    variables: Iterable[PlacedVariable],
    by_python: Collection[str],
    *,
    exceptions: bool,
    cached: bool,
    counted: Mapping[str, int] | None = None,
    counters: int = 0,
    conditions: bool = False,
) -> bytes:
    """The object file of a project. `cached`: what is in the cache will do. `counted` has the
    number of the first of all `counters` for each routine whose statements count."""
    kept: ObjectCache | None = None
    if cached:
        options = f"{exceptions} {conditions} {sorted((counted or {}).items())}"
        kept = ObjectCache(_NAME, _digest(project, placement, variables, by_python, options))
        content = kept.load()
        if content is not None:
            return content
    module = ProjectTranslator(
        project,
        placement,
        by_python,
        exceptions=exceptions,
        counted=counted,
        counters=counters,
        conditions=conditions,
    )
    content = compile_module(module.translated(), Effort.FAST)
    if kept is not None:
        kept.save(content)
    return content


def _digest(
    project: TypedProject,
    placement: Placement,
    variables: Iterable[PlacedVariable],
    by_python: Collection[str],
    options: str,
) -> str:
    found = hashlib.blake2b(_own_code(), digest_size=20)
    found.update(f"{identity()} {options} {sorted(by_python)} {project.origin}".encode())
    found.update(repr([len(placement.memory[area]) for area in Area]).encode())
    sources: dict[int, int] = {}
    for key, routine in project.routines.items():
        source = routine.source
        sources.setdefault(id(source), len(sources))
        statements = [one.at for one in routine.body] if routine.body is not None else None
        frame = [(each.name, each.offset, each.type.name) for each in routine.frame.fields]
        found.update(
            f"{key} {routine.kind} {routine.at} {sources[id(source)]} {statements} {frame}"
            f" {sorted(routine.addressed)}".encode()
        )
        found.update(routine.frame.default)
    for placed in variables:
        spot = f"{placed.name} {placed.area} {placed.offset} {placed.bit}"
        found.update(f"{spot} {placed.variable.type.guid!r}".encode())
    for static in project.statics:
        found.update(f"{static.owner} {static.variable.name} {placement.spot(static)}".encode())
    for block in project.blocks.values():
        table = sorted(block.table.items())
        found.update(f"{block.type.name} {block.number} {block.type.guid!r} {table}".encode())
    for record in project.records.values():
        found.update(f"{record.type.name} {record.type.guid!r}".encode())
    for unit in project.units.values():
        found.update(unit.type.default)
    return found.hexdigest()


@cache
def _own_code() -> bytes:
    """A hash of our own part in what comes out: parser, checker, types, front and back end."""
    found = hashlib.blake2b()
    root = Path(__file__).parents[2]
    for room in ("iec", "st", "plc", "native/backend"):
        for file in sorted((root / room).rglob("*.py")):
            found.update(file.read_bytes())
    return found.digest()
