"""Every library routine is checked and made into code: a fault in one that no test names shows."""

from achse.st.declared.standard import standard_libraries
from achse.st.syntax.units import Function, FunctionBlock
from tests.plc.code.conftest import Ran


def test_no_library_routine_has_a_fault() -> None:
    units = [unit for parsed in standard_libraries() for unit in parsed.units]
    blocks = [
        f"{parsed.source.library}.{unit.name}"
        for parsed in standard_libraries()
        for unit in parsed.units
        if isinstance(unit, FunctionBlock) and "ABSTRACT" not in unit.modifiers
    ]
    functions = [unit for unit in units if isinstance(unit, Function)]
    seen = {
        unit.name: f"{parsed.source.library}.{unit.name}"
        for parsed in standard_libraries()
        for unit in parsed.units
        if isinstance(unit, Function) and "INTERNAL" in unit.modifiers
    }
    declared = "".join(f" fb{number} : {name};" for number, name in enumerate(blocks))
    calls = ""
    for unit in functions:
        names = []
        for block in unit.blocks:
            for variable in block.variables if block.section in _CALLED else ():
                for name in variable.names:
                    # What a place of its own would be told apart by is the name of the routine.
                    declared += f" {unit.name}_{name.name} : {_typed(variable.type)};"
                    names.append(f"{unit.name}_{name.name}")
        calls += f" IF FALSE THEN {seen.get(unit.name, unit.name)}({', '.join(names)}); END_IF"
    ran = Ran(f"PROGRAM MAIN VAR {declared} END_VAR {calls} END_PROGRAM").cycle()
    assert ran.plc.failure == ""
    called = {seen.get(unit.name, unit.name).lower() for unit in functions}
    assert called <= ran.typed.routines.keys()
    execution = ran.plc.bodies.execution if ran.plc.bodies is not None else None
    assert execution is not None
    assert execution.left_out == {}


def test_a_project_may_use_the_names_of_private_routines() -> None:
    """Each private block and function of a library is declared by the project too, as its own."""
    private = [
        unit
        for parsed in standard_libraries()
        for unit in parsed.units
        if isinstance(unit, Function | FunctionBlock) and "INTERNAL" in unit.modifiers
    ]
    names = sorted({unit.name.lower() for unit in private})
    assert len(names) > 30
    own = "".join(f"FUNCTION {name} : INT {name} := 1; END_FUNCTION " for name in names)
    calls = " + ".join(f"{name}()" for name in names)
    move = "ax : AXIS_REF; move : MC_MoveAbsolute; read : ADSREAD;"
    ran = Ran(f"{own} PROGRAM MAIN VAR n : INT; {move} END_VAR n := {calls}; END_PROGRAM").cycle()
    assert ran.plc.failure == ""
    assert ran["n"] == len(names)


_CALLED = ("VAR_INPUT", "VAR_IN_OUT")


def _typed(type: object) -> str:
    """A type as it stands in a declaration."""
    target = getattr(type, "target", None)
    if target is not None:
        return f"POINTER TO {_typed(target)}"
    dimensions = getattr(type, "dimensions", None)
    if dimensions is not None:
        ranges = ", ".join(f"{each.low.text}..{each.high.text}" for each in dimensions)
        return f"ARRAY [{ranges}] OF {_typed(getattr(type, 'element'))}"  # noqa: B009
    base = getattr(type, "base", None)
    if base is not None:
        return _typed(base)
    family = getattr(type, "family", None)
    if family is None:
        return str(getattr(type, "name"))  # noqa: B009
    length = getattr(type, "length", None)
    return str(family) if length is None else f"{family}({length.text})"
