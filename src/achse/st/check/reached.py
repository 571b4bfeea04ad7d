"""The typed form of a project whose unreached units have faults: without these units."""

from collections.abc import Container, Mapping
from dataclasses import replace

from achse.st.lexis.source import Diagnostic
from achse.st.reach import Reach
from achse.st.typed.project import Routine, TypedProject

FAULTY = "it has faults"
"""Reason why a routine with faults is left out."""

_UNREACHED = "it has faults, and no program of a task reached it"


def of_reached(
    project: TypedProject, reach: Reach, unreached: tuple[Diagnostic, ...]
) -> TypedProject:
    """Return a project with the faults of its reached units only.

    Unreached units with faults, those of the declarations (`unreached`) included, are left out
    with all that depends on them. If a routine of a reached unit has a fault that no error
    explains, all faults are errors.
    """
    if not project.faults and not unreached:
        return project
    errors, faulty = faults_by_reach(tuple(project.faults), project.left_out, reach, unreached)
    if not faulty:
        return project if errors == tuple(project.faults) else replace(project, faults=errors)
    gone = reach.dependent_on(faulty)
    routines = {
        key: routine for key, routine in project.routines.items() if _unit_of(routine) not in gone
    }
    reasons = dict.fromkeys(project.routines.keys() - routines.keys(), _UNREACHED)
    return replace(
        project,
        routines=routines,
        records={
            key: record for key, record in project.records.items() if _declared(key) not in gone
        },
        blocks={key: block for key, block in project.blocks.items() if _declared(key) not in gone},
        units={key: unit for key, unit in project.units.items() if key not in gone},
        interfaces={key: one for key, one in project.interfaces.items() if key not in gone},
        init_calls=[call for call in project.init_calls if call.routine in routines],
        online_change_calls=[
            call for call in project.online_change_calls if call.routine in routines
        ],
        type_change_calls=[call for call in project.type_change_calls if call.routine in routines],
        statics=[static for static in project.statics if not _is_in(static.owner.lower(), gone)],
        faults=errors,
        unreached=faulty,
        left_out={**project.left_out, **reasons},
    )


def faults_by_reach(
    faults: tuple[Diagnostic, ...],
    left_out: Mapping[str, str],
    reach: Reach,
    unreached: tuple[Diagnostic, ...],
) -> tuple[tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
    """Return the faults of a check that are errors, and all faults of unreached units.

    `unreached` are those of declarations, `left_out` has routines with the reasons.
    """
    if not faults and not unreached:
        return (), ()
    errors, further = reach.findings(faults)
    if not reach.has_errors:
        reached = {entry.name.lower() for entry in reach.units}
        if any(_is_in(key, reached) for key, reason in left_out.items() if reason == FAULTY):
            return (*unreached, *faults), ()
    return tuple(errors), tuple(sorted({*unreached, *further}, key=lambda fault: fault.location))


def _unit_of(routine: Routine) -> str:
    """Return the key of the unit that a routine belongs to."""
    return _declared(routine.owner or routine.key)


def _is_in(key: str, units: Container[str]) -> bool:
    """Return True if a key is that of one of these units or of a part of one."""
    while key:
        if _declared(key) in units:
            return True
        key = key.rpartition(".")[0]
    return False


def _declared(key: str) -> str:
    """Return the key of the declaration of an instance of a generic block."""
    return key.partition("<")[0]
