"""What random programs have besides: unions, enumerations, edges, what catches faults, actions.

Each function gives the declarations of MAIN, and puts what is done with them into the scope.
"""

from contextlib import suppress
from random import Random
from typing import Any

from tests.rules.oracle import (
    INTEGERS,
    WIDTHS,
    Action,
    Back,
    Cell,
    Env,
    Stop,
    converted,
    wrap,
)
from tests.rules.random_programs import Scope

UNION = """TYPE U_All : UNION
    n : UDINT; i : DINT; w : ARRAY [0..1] OF WORD; b : ARRAY [0..3] OF BYTE; s : SINT;
END_UNION
END_TYPE"""
_PARTS = [
    ("n", "UDINT", 0), ("i", "DINT", 0), ("w[0]", "WORD", 0), ("w[1]", "WORD", 2),
    ("b[0]", "BYTE", 0), ("b[1]", "BYTE", 1), ("b[3]", "BYTE", 3), ("s", "SINT", 0),
]  # fmt: skip
"""Members of the union: type, and where they are."""


def union(name: str, scope: Scope) -> str:
    """Bytes that have several names."""
    data = bytearray(4)

    def written(of: Scope) -> Action:
        member, type, at = of.rng.choice(_PARTS)
        value = of.argument(type, 2)
        size = WIDTHS[type][0] // 8

        def run(env: Env) -> None:
            number = converted(value.run(env), value.type, type)
            data[at : at + size] = (number % (1 << 8 * size)).to_bytes(size, "little")

        return Action(f"{name}.{member} := {value.text};", run)

    def taken(of: Scope) -> Action:
        member, type, at = of.rng.choice(_PARTS)
        place = of.any_place(*INTEGERS)
        assert place is not None
        size = WIDTHS[type][0] // 8

        def run(env: Env) -> None:
            number = wrap(int.from_bytes(data[at : at + size], "little"), type)
            place.cell(env).v = wrap(number, place.type)

        return Action(f"{place.text} := {name}.{member};", run)

    def cleared() -> None:
        data[:] = bytes(4)

    scope.again.append(cleared)
    scope.calls += [written, taken, taken]
    return f"    {name} : U_All;"


def enumeration(rng: Random, name: str, scope: Scope) -> tuple[str, str]:
    """An enumeration of a base type, with a variable: its declaration and that of the type."""
    base = rng.choice(["SINT", "USINT", "INT", "UINT", "DINT", "LINT"])
    low = -(1 << WIDTHS[base][0] - 1) if base in ("SINT", "INT", "DINT", "LINT") else 0
    values = {"eA": rng.randint(low // 2, 50), "eC": rng.randint(60, 120)}
    values["eB"] = values["eA"] + 1
    values["eD"] = values["eC"] + 1
    first = rng.choice(list(values))
    type = f"E_{name}"
    text = (
        f"{{attribute 'qualified_only'}}\nTYPE {type} : (eA := {values['eA']}, eB,"
        f" eC := {values['eC']}, eD) {base} := {first};\nEND_TYPE"
    )
    cell = Cell(values[first])

    def chosen(of: Scope) -> Action:
        word = of.rng.choice(list(values))

        def run(env: Env) -> None:
            cell.v = values[word]

        return Action(f"{name} := {type}.{word};", run)

    def counted(of: Scope) -> Action:
        by = of.rng.randint(0, 3)

        def run(env: Env) -> None:
            cell.v = wrap(cell.v + by, base)

        return Action(f"{name} := {name} + {by};", run)

    def taken(of: Scope) -> Action:
        place = of.any_place(*INTEGERS)
        assert place is not None

        def run(env: Env) -> None:
            place.cell(env).v = wrap(cell.v, place.type)

        return Action(f"{place.text} := {name};", run)

    def cases(of: Scope) -> Action:
        place = of.any_place(*INTEGERS)
        assert place is not None
        words = of.rng.sample(list(values), 2)

        def run(env: Env) -> None:
            matches = [number for number, word in enumerate(words) if values[word] == cell.v]
            place.cell(env).v = matches[0] if matches else 9

        labels = "\n".join(f"{type}.{w}: {place.text} := {n};" for n, w in enumerate(words))
        return Action(f"CASE {name} OF\n{labels}\nELSE {place.text} := 9;\nEND_CASE", run)

    def begun() -> None:
        cell.v = cell.start

    scope.again.append(begun)
    scope.calls += [chosen, counted, taken, cases]
    return f"    {name} : {type};", text


def edge(rng: Random, name: str, scope: Scope) -> str:
    """A block that sees edges."""
    rises = rng.random() < 0.5
    before = [False]

    def called(of: Scope) -> Action:
        clock, place = of.boolean(2), of.any_place("BOOL")
        assert place is not None

        def run(env: Env) -> None:
            now = bool(clock.run(env))
            place.cell(env).v = now and not before[0] if rises else before[0] and not now
            before[0] = now

        return Action(f"{name}(CLK := {clock.text}, Q => {place.text});", run)

    def begun() -> None:
        before[0] = False

    scope.again.append(begun)
    scope.calls.append(called)
    return f"    {name} : {'R_TRIG' if rises else 'F_TRIG'};"


def guarded(name: str, scope: Scope) -> str:
    """What may stop the program and is caught."""

    def tried(of: Scope) -> Action:
        place, other, last = (of.any_place(*INTEGERS) for _ in range(3))
        assert place is not None
        assert other is not None
        assert last is not None
        value, instead = of.integer(3), of.rng.randint(0, 100)

        def run(env: Env) -> None:
            try:
                place.cell(env).v = wrap(value.run(env), place.type)
            except Stop:
                other.cell(env).v = instead
            last.cell(env).v = wrap(last.cell(env).v + 1, last.type)

        return Action(
            f"__TRY\n{place.text} := {value.text};\n__CATCH({name})\n"
            f"{other.text} := {instead};\n__FINALLY\n{last.text} := {last.text} + 1;\n__ENDTRY",
            run,
        )

    scope.calls.append(tried)
    return f"    {name} : __SYSTEM.ExceptionCode;"


def action(name: str, scope: Scope) -> str:
    """An action of the program: its text; calls of it join the scope."""
    before = scope.may_return
    scope.may_return = True
    body = scope.block(2)
    scope.may_return = before

    def called(of: Scope) -> Action:
        def run(env: Env) -> None:
            with suppress(Back):
                body.run(env)

        return Action(f"{name}();", run)

    scope.calls += [called] * 2
    return f"ACTION {name}:\n{body.text}\nEND_ACTION\n"


def shapes(rng: Random, names: Any, scope: Scope) -> tuple[list[str], list[str], str]:
    """Declarations of MAIN, types, and actions; `names` gives a new name that begins so."""
    lines, types = [], []
    if rng.random() < 0.6:
        types.append(UNION)
        lines.append(union(names("u"), scope))
    if rng.random() < 0.6:
        line, type = enumeration(rng, names("e"), scope)
        lines.append(line)
        types.append(type)
    if rng.random() < 0.6:
        lines.append(edge(rng, names("r"), scope))
    if rng.random() < 0.6:
        lines.append(guarded(names("x"), scope))
    actions = action(names("A_"), scope) if rng.random() < 0.6 else ""
    return lines, types, actions
