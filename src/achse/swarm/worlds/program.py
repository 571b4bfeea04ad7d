"""Programs of the PLC of a world: Structured Text that never fails, with a counter to watch."""

from collections.abc import Sequence

from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Program

COUNTER = "MAIN.nCycle"
"""Variable that counts the cycles of the program."""

SAVED = "MAIN.nSaved"
"""Variable that outlives the station, written by clients and counted up by the program."""

TASK_NS = 10_000_000
"""Cycle of the task."""

_TYPES = ("INT", "DINT", "UDINT", "LREAL", "REAL", "BOOL", "STRING(20)", "ARRAY[0..3] OF DINT")

_NUMBERS = ("INT", "DINT", "UDINT", "LREAL", "REAL")


def draw_programs(draws: Stream) -> list[Program]:
    """Draw a program, and what online changes make of it."""
    names = [f"v{number}" for number in range(draws.randrange(1, 6))]
    variables = {name: draws.choice(_TYPES) for name in names}
    programs = []
    for _ in range(draws.randrange(1, 4)):
        programs.append(Program(dict(variables), _statements(draws, variables)))
        change = draws.choice(("add", "retype", "remove", "body"))
        if change == "add":
            variables[f"w{len(programs)}"] = draws.choice(_TYPES)
        elif change == "retype":
            variables[draws.choice(list(variables))] = draws.choice(_TYPES)
        elif change == "remove" and len(variables) > 1:
            del variables[draws.choice(list(variables))]
    return programs


def _statements(draws: Stream, variables: dict[str, str]) -> list[str]:
    return [_statement(draws, name, type) for name, type in variables.items() if draws.chance(0.7)]


def _statement(draws: Stream, name: str, type: str) -> str:
    number = draws.randrange(1, 100)
    if type in ("LREAL", "REAL"):
        return f"{name} := {name} * 0.5 + {number}.0;"
    if type in _NUMBERS:
        return f"IF nCycle MOD {number} = 0 THEN {name} := 1; ELSE {name} := {name} XOR 1; END_IF"
    if type == "BOOL":
        return f"{name} := nCycle MOD {number} = 0;"
    if type.startswith("STRING"):
        return f"{name} := 'n{number}';"
    return f"FOR i := 0 TO 3 DO {name}[i] := {name}[3 - i] XOR {number}; END_FOR"


def source_of(program: Program) -> str:
    """Return the source text."""
    lines = [f"  {name} : {type};" for name, type in program.variables.items()]
    body = [f"{statement}" for statement in program.statements]
    return "\n".join(
        [
            "PROGRAM MAIN",
            *("VAR", "  nCycle : UDINT;", "  i : DINT;", *lines, "END_VAR"),
            *("VAR PERSISTENT", "  nSaved : UDINT;", "END_VAR"),
            "nCycle := nCycle + 1;",
            *body,
            "END_PROGRAM",
            "",
        ]
    )


def symbols_of(programs: Sequence[Program]) -> list[str]:
    """Return the names of all variables that clients may ask for."""
    names = {f"MAIN.{name}" for program in programs for name in program.variables}
    return [COUNTER, SAVED, *sorted(names)]
