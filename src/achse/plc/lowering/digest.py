"""Digest of a typed project in the memory of a PLC: it differs wherever emitted code could."""

import hashlib
from collections.abc import Collection, Iterable, Mapping

from achse.plc.lowering.placement import Placement
from achse.plc.memory import Area
from achse.plc.program import PlacedVariable
from achse.st.typed.project import TypedProject


def project_digest(
    project: TypedProject,
    placement: Placement,
    variables: Iterable[PlacedVariable],
    by_python: Collection[str],
    *,
    exceptions: bool,
    counted: Mapping[str, int] | None = None,
    conditions: bool = False,
) -> str:
    """Digest of all inputs of the typed form (`achse.st.check.origin`), the types and places of all
    variables, and the options of lowering."""
    digest = hashlib.blake2b(digest_size=20)
    options = f"{exceptions} {conditions} {sorted((counted or {}).items())}"
    digest.update(f"{options} {sorted(by_python)} {project.origin}".encode())
    digest.update(repr([len(placement.memory[area]) for area in Area]).encode())
    sources: dict[int, int] = {}
    for key, routine in project.routines.items():
        source = routine.source
        sources.setdefault(id(source), len(sources))
        statements = [one.at for one in routine.body] if routine.body is not None else None
        frame = [(each.name, each.offset, each.type.name) for each in routine.frame.fields]
        digest.update(
            f"{key} {routine.kind} {routine.at} {sources[id(source)]} {statements} {frame}"
            f" {sorted(routine.addressed)}".encode()
        )
        digest.update(routine.frame.default)
    for placed in variables:
        spot = f"{placed.name} {placed.area} {placed.offset} {placed.bit}"
        digest.update(f"{spot} {placed.variable.type.guid!r}".encode())
    for static in project.statics:
        digest.update(f"{static.owner} {static.variable.name} {placement.spot(static)}".encode())
    for block in project.blocks.values():
        table = sorted(block.table.items())
        digest.update(f"{block.type.name} {block.number} {block.type.guid!r} {table}".encode())
    for record in project.records.values():
        digest.update(f"{record.type.name} {record.type.guid!r}".encode())
    for unit in project.units.values():
        digest.update(unit.type.default)
    return digest.hexdigest()
