"""Types of missing names by what takes them: standard functions, declared methods, variables.

Source: IEC 61131-3 (2013) tables 19 (calls), 29 (functions of strings), 48 (methods).
"""

from achse.iec.names import ELEMENTARY
from achse.st.declared.scopes import Scope
from achse.st.missing.built_in import argument_text
from achse.st.missing.meanings import Meanings
from achse.st.missing.trees import parameters_of
from achse.st.missing.type_texts import expression_text, spec_text
from achse.st.missing.uses import MissingUse
from achse.st.syntax.tree import Call, Expression, Literal, TypeSpec
from achse.st.syntax.units import Method


def note_standard_call(meanings: Meanings, name: str, tree: Call, scope: Scope) -> None:
    """Note what a standard function takes."""
    for place, argument in enumerate(tree.arguments):
        if name.upper() == "__ISVALIDREF" and argument.value is not None:
            sense = meanings.of(argument.value, scope)
            if isinstance(sense, MissingUse):
                sense.is_reference = True
        text = argument_text(name, place)
        if text and argument.value is not None and not argument.name:
            _note(meanings, argument.value, text, scope)


def note_method_call(
    meanings: Meanings, method: Method, inside: Scope, tree: Call, scope: Scope
) -> None:
    """Note what a declared method takes; `inside` is the scope of its unit."""
    inputs = parameters_of(method)
    named = {
        name.name.lower(): declaration.type
        for block in method.blocks
        for declaration in block.variables
        for name in declaration.names
    }
    for place, argument in enumerate(tree.arguments):
        positional = inputs[place] if place < len(inputs) else None
        spec = named.get(argument.name.lower()) if argument.name else positional
        if spec is not None and argument.value is not None:
            _note(meanings, argument.value, spec_text(meanings, (spec, inside)), scope)


def note_value(
    meanings: Meanings, at: tuple[TypeSpec, Scope], value: Expression, scope: Scope
) -> None:
    """Note the value of a variable: a missing type may be elementary (`s : STRING256 := 'x'`)."""
    use = meanings.types.use_at(at)
    if use is None or (isinstance(value, Literal) and value.text == "0"):
        return  # 0 is an interface, too
    text = expression_text(meanings, value, scope)
    if text.partition("(")[0].lower() in ELEMENTARY:
        use.note_type(text)


def _note(meanings: Meanings, tree: Expression, text: str, scope: Scope) -> None:
    sense = meanings.of(tree, scope)
    if isinstance(sense, MissingUse):
        sense.note_type(text)
