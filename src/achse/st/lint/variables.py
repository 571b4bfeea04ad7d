"""Rules about variables: unused, never written, never read, shadowed, instances that forget."""

from collections.abc import Iterator, Mapping, Sequence

from achse.st.declared.scopes import Scopes, with_bases
from achse.st.lexis.codes import Code
from achse.st.lint.declared_types import DeclaredTypes
from achse.st.lint.report import LintReport
from achse.st.lint.uses import (
    Owner,
    TrackedUnit,
    TrackedVariable,
    TrackedVariables,
    UseKind,
    uses_of,
)
from achse.st.syntax.tree import ReferenceTo
from achse.st.syntax.units import (
    Accessor,
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Method,
    Program,
)

RULES = (
    Code.UNUSED_VARIABLE,
    Code.NEVER_WRITTEN,
    Code.NEVER_READ,
    Code.SHADOWED_NAME,
    Code.TEMPORARY_INSTANCE,
)

_LOCAL = frozenset(("VAR", "VAR_TEMP", "VAR_STAT", "VAR_INST"))
_PARAMETERS = frozenset(("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT"))
_KEPT = frozenset(("RETAIN", "PERSISTENT"))
_OF_THE_RUNTIME = frozenset(("fb_init", "fb_exit", "fb_reinit"))


def check_variables(units: Sequence[TrackedUnit], scopes: Scopes, report: LintReport) -> None:
    """Apply the rules to the variables of all units."""
    if not report.wants(*RULES):
        return
    uses_of(units, scopes)
    types = DeclaredTypes(scopes)
    extended = frozenset(key for unit in units for key in _bases(unit, scopes))
    for unit in units:
        tree = unit.entry.tree
        if isinstance(tree, GlobalList):
            continue
        inherited = _inherited(unit, scopes) if isinstance(tree, FunctionBlock) else {}
        outer = {**inherited, **dict.fromkeys(unit.variables, unit.entry.name)}
        for owner, variables in _owners(unit):
            for key, variable in variables.items():
                is_free = unit.entry.name.lower() not in extended and _is_free(variable, unit)
                _check_use(variable, is_free, types, report)
                around = None if owner is tree else outer.get(key)
                _check_shadow(variable, around, scopes, report)
                _check_instance(variable, types, report)


def _owners(unit: TrackedUnit) -> Iterator[tuple[Owner, TrackedVariables]]:
    tree = unit.entry.tree
    assert isinstance(tree, Function | FunctionBlock | Program)
    yield tree, unit.variables
    for owner, own in unit.parts:
        if not isinstance(owner, Action):
            yield owner, own


def _bases(unit: TrackedUnit, scopes: Scopes) -> list[str]:
    """Return the keys of the blocks that a block extends, directly or not."""
    return [scope.owner.lower() for scope in with_bases(scopes.scope(unit.entry))][1:]


def _inherited(unit: TrackedUnit, scopes: Scopes) -> Mapping[str, str]:
    """Return the variables of the bases of a block, with the names of the bases."""
    bases = list(with_bases(scopes.scope(unit.entry)))[1:]
    return {key: scope.owner for scope in reversed(bases) for key in scope.variables}


def _check_use(
    variable: TrackedVariable, is_free: bool, types: DeclaredTypes, report: LintReport
) -> None:
    """Check the uses of a variable; a parameter is free if it may be left out."""
    declaration, block = variable.declaration, variable.block
    name, section = variable.name, block.section
    if (
        variable.use is UseKind.BOTH
        or declaration.address is not None
        or declaration.note.attributes
    ):
        return
    if types.may_be_block(declaration, variable.entry.space):
        return  # FB_init may be all that is wanted
    if not variable.use:
        if section in _LOCAL or (section in _PARAMETERS and is_free):
            what = "parameter" if section in _PARAMETERS else "variable"
            message = f"{what} '{name.name}' is not used"
            report.add(Code.UNUSED_VARIABLE, variable.source, name.at, message)
        return
    if section not in _LOCAL or isinstance(declaration.type, ReferenceTo):
        return
    if isinstance(variable.owner, Program) and section != "VAR_TEMP":
        return  # clients read and write variables of programs
    if "CONSTANT" in block.qualifiers or not _KEPT.isdisjoint(block.qualifiers):
        return
    if (
        variable.use is UseKind.READ
        and declaration.initial is None
        and not types.has_default(declaration, variable.entry.space)
    ):
        message = f"'{name.name}' is read, but nothing writes it"
        report.add(Code.NEVER_WRITTEN, variable.source, name.at, message)
    elif variable.use is UseKind.WRITE:
        message = f"'{name.name}' is written, but nothing reads it"
        report.add(Code.NEVER_READ, variable.source, name.at, message)


def _is_free(variable: TrackedVariable, unit: TrackedUnit) -> bool:
    """Return True if no interface, base or derived block decides on a parameter."""
    owner, tree = variable.owner, unit.entry.tree
    if isinstance(owner, Function):
        return True
    if isinstance(owner, FunctionBlock):
        return not owner.implements and owner.extends is None and "ABSTRACT" not in owner.modifiers
    if not isinstance(owner, Method) or owner.name.lower() in _OF_THE_RUNTIME:
        return False
    is_alone = isinstance(tree, FunctionBlock) and tree.extends is None and not tree.implements
    return is_alone and "ABSTRACT" not in owner.modifiers and bool(owner.body)


def _check_shadow(
    variable: TrackedVariable, around: str | None, scopes: Scopes, report: LintReport
) -> None:
    """Report a variable of a method that hides one of its block, or any that hides a global one."""
    name = variable.name
    if around is None:
        lists = scopes.globals.get(name.name.lower(), ())
        own = next((entry for entry in lists if not entry.is_library), None)
        around = None if own is None else own.name
    if around is not None:
        message = f"'{name.name}' hides the variable of that name of {around}"
        report.add(Code.SHADOWED_NAME, variable.source, name.at, message)


def _check_instance(variable: TrackedVariable, types: DeclaredTypes, report: LintReport) -> None:
    """Report an instance of a block that needs several calls but starts again in each call."""
    section = variable.block.section
    in_call = isinstance(variable.owner, Function | Method | Accessor)
    if section != "VAR_TEMP" and not (in_call and section == "VAR"):
        return
    if types.takes_several_calls(variable.declaration, variable.entry.space):
        message = f"'{variable.name.name}' is an instance that starts again with each call"
        report.add(Code.TEMPORARY_INSTANCE, variable.source, variable.name.at, message)
