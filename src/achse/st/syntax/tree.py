"""The syntax tree of Structured Text: one class per construct, in the order of the grammar.

The units of a source, made of all this, are in `units`.

Every node knows its place: `at` is the offset in its `Source` of the sign that makes it what it
is (the operator, the name after a dot, the keyword). Places do not count when nodes are compared.
"""

from typing import TypeAlias

from achse.st.syntax.nodes import node, place

# Expressions --------------------------------------------------------------------------------


@node
class Literal:
    """`5`, `16#FF`, `1.5E3`, `TRUE`, `'text'`, `T#1s`, `INT#5`, `E_State#Idle`: as written."""

    kind: str
    """integer, real, boolean, string (quoted ' or "), or typed (`prefix#value`)."""
    text: str
    at: int = place()


@node
class Name:
    """`nCounter`."""

    name: str
    at: int = place()


@node
class GlobalName:
    """`.nCounter`: of the global name space, whatever is local."""

    name: str
    at: int = place()


@node
class This:
    """`THIS`."""

    at: int = place()


@node
class Super:
    """`SUPER`."""

    at: int = place()


@node
class Member:
    """`of.name`: member, global variable, enumeration value, or part of a name space."""

    of: "Expression"
    name: str
    at: int = place()


@node
class PartOf:
    """`of.3` or `of.%X3` (a bit), `of.%B1` (a byte), `%W`, `%D`, `%L`."""

    of: "Expression"
    width: str
    """X, B, W, D or L."""
    number: int
    at: int = place()


@node
class Index:
    """`of[i, j]`."""

    of: "Expression"
    indices: "tuple[Expression, ...]"
    at: int = place()


@node
class Dereference:
    """`of^`."""

    of: "Expression"
    at: int = place()


@node
class Argument:
    """`5`, `nIn := 5`, `nOut => x`; without a value `nIn :=` and `nOut =>`."""

    name: str
    """Empty for an argument by position."""
    value: "Expression | None"
    is_output: bool
    at: int = place()


@node
class Call:
    """`of(arguments)`: function, instance, method, cast (`TO_INT`), operator (`ADR`, `__NEW`)."""

    of: "Expression"
    arguments: tuple[Argument, ...]
    at: int = place()


@node
class Unary:
    """`-x`, `+x`, `NOT x`."""

    operator: str
    operand: "Expression"
    at: int = place()


@node
class Binary:
    """`left operator right`; `&` is AND."""

    operator: str
    left: "Expression"
    right: "Expression"
    at: int = place()


@node
class Assign:
    """`target := value`, `REF=`, `S=`, `R=`: a statement, and with `:=` also an expression."""

    operator: str
    target: "Expression"
    value: "Expression"
    at: int = place()


@node
class DirectAddress:
    """`%IX0.3`, `%Q*`: after AT in a declaration, or in a body."""

    text: str
    at: int = place()


@node
class TypeOperand:
    """A type where a value could stand: `__NEW(POINTER TO INT)`, `SIZEOF(STRING(80))`. Of a type
    with a plain name only its place shows that it is one."""

    type: "TypeSpec"
    at: int = place()


Expression: TypeAlias = (
    Literal
    | Name
    | GlobalName
    | This
    | Super
    | Member
    | PartOf
    | Index
    | Dereference
    | Call
    | Unary
    | Binary
    | Assign
    | DirectAddress
    | TypeOperand
)

# Initial values -----------------------------------------------------------------------------


@node
class Repetition:
    """`3(0, 1)` in an array: the values three times over."""

    count: Expression
    values: "tuple[Initial, ...]"
    at: int = place()


@node
class ArrayInitial:
    """`[1, 2, 3(0)]`."""

    values: "tuple[Initial | Repetition, ...]"
    at: int = place()


@node
class MemberInitial:
    """`a := 1` or `r REF= x` of a structure's initial value."""

    name: str
    """Empty for an argument by position in `ARRAY [0..1] OF FB_Valve[(3, 4), (5, 6)]`."""
    value: "Initial"
    at: int = place()
    is_reference: bool = False
    """True if it came with `REF=`."""


@node
class StructInitial:
    """`(a := 1, b := [1, 2])`."""

    members: tuple[MemberInitial, ...]
    at: int = place()


Initial: TypeAlias = Expression | ArrayInitial | StructInitial

# Statements ---------------------------------------------------------------------------------


@node
class Branch:
    """`IF condition THEN body`, or ELSIF."""

    condition: Expression
    body: "Statements"
    at: int = place()


@node
class If:
    """`IF … ELSIF … ELSE … END_IF`."""

    branches: tuple[Branch, ...]
    otherwise: "Statements"
    at: int = place()


@node
class Range:
    """`low..high`: of labels, bounds and sub-ranges."""

    low: Expression
    high: Expression
    at: int = place()


@node
class Choice:
    """`1, 3..5: body` in a CASE."""

    labels: tuple[Expression | Range, ...]
    body: "Statements"
    at: int = place()


@node
class Case:
    """`CASE selector OF … ELSE … END_CASE`."""

    selector: Expression
    choices: tuple[Choice, ...]
    otherwise: "Statements"
    at: int = place()
    has_empty_else: bool = False
    """True if there is an ELSE without statements."""


@node
class For:
    """`FOR variable := first TO last BY step DO body END_FOR`."""

    variable: Expression
    first: Expression
    last: Expression
    step: Expression | None
    body: "Statements"
    at: int = place()


@node
class While:
    """`WHILE condition DO body END_WHILE`."""

    condition: Expression
    body: "Statements"
    at: int = place()


@node
class RepeatUntil:
    """`REPEAT body UNTIL condition END_REPEAT`."""

    body: "Statements"
    condition: Expression
    at: int = place()


@node
class Try:
    """`__TRY body __CATCH(exception) handler __FINALLY final __ENDTRY`."""

    body: "Statements"
    exception: Expression | None
    handler: "Statements"
    final: "Statements"
    at: int = place()


@node
class Exit:
    """`EXIT`."""

    at: int = place()


@node
class Continue:
    """`CONTINUE`."""

    at: int = place()


@node
class Return:
    """`RETURN`."""

    at: int = place()


@node
class Jump:
    """`JMP label`."""

    label: str
    at: int = place()


@node
class Label:
    """`label:`."""

    name: str
    at: int = place()


@node
class Let:
    """A hidden variable of the call, with the type of its value: only drawn bodies make one."""

    name: str
    value: Expression
    at: int = place()


Statement: TypeAlias = (
    Assign
    | Call
    | Name
    | GlobalName
    | Member
    | Dereference
    | Index
    | If
    | Case
    | For
    | While
    | RepeatUntil
    | Try
    | Exit
    | Continue
    | Return
    | Jump
    | Label
    | Let
)
"""A bare name is a call without parentheses: of an action, a program, a method."""

Statements: TypeAlias = tuple[Statement, ...]

# Types --------------------------------------------------------------------------------------


@node
class NamedType:
    """`INT`, `ST_Axis`, `Tc2_MC2.AXIS_REF`; `FB_List<8>` of a block with VAR_GENERIC."""

    name: str
    generics: tuple[Expression, ...] = ()
    at: int = place()


@node
class StringOf:
    """`STRING`, `STRING(80)`, `WSTRING[nMax]`."""

    family: str
    """STRING or WSTRING."""
    length: Expression | None
    at: int = place()


@node
class ArrayOf:
    """`ARRAY [1..10, 0..nMax] OF element`; a dimension is None for `*`."""

    dimensions: tuple[Range | None, ...]
    element: "TypeSpec"
    at: int = place()


@node
class PointerTo:
    """`POINTER TO target`."""

    target: "TypeSpec"
    at: int = place()


@node
class ReferenceTo:
    """`REFERENCE TO target`."""

    target: "TypeSpec"
    at: int = place()


@node
class Subrange:
    """`INT (0..100)`."""

    base: NamedType
    limits: Range
    at: int = place()


@node
class Note:
    """Comment and attribute pragmas of a declaration, the pragmas in order."""

    comment: str = ""
    attributes: tuple[tuple[str, str], ...] = ()


NO_NOTE = Note()


@node
class EnumValue:
    """`Idle := 0`."""

    name: str
    value: Expression | None
    note: Note
    at: int = place()


@node
class EnumOf:
    """`(Idle := 0, Run) UINT`."""

    values: tuple[EnumValue, ...]
    base: NamedType | None
    at: int = place()


@node
class StructOf:
    """`STRUCT … END_STRUCT`."""

    members: "tuple[Declaration, ...]"
    at: int = place()


@node
class UnionOf:
    """`UNION … END_UNION`."""

    members: "tuple[Declaration, ...]"
    at: int = place()


TypeSpec: TypeAlias = (
    NamedType
    | StringOf
    | ArrayOf
    | PointerTo
    | ReferenceTo
    | Subrange
    | EnumOf
    | StructOf
    | UnionOf
)

# Variables ----------------------------------------------------------------------------------


@node
class Declaration:
    """`a, b AT %MD4 : type(arguments) := initial;` with the same type and value for all names."""

    names: tuple[Name, ...]
    """Names; in VAR_CONFIG paths: `MAIN.fbValve.bOpen`, or `.bOpen` of a global variable."""
    address: DirectAddress | None
    type: TypeSpec
    arguments: tuple[Argument, ...] | ArrayInitial
    """Of FB_init: `fbValve : FB_Valve(nPort := 3)`, or for each element of an array
    `ARRAY [0..1] OF FB_Valve[(nPort := 3), (nPort := 4)]`."""
    initial: Initial | None
    note: Note
    is_reference: bool = False
    """True if the initial value came with `REF=`."""


@node
class VarBlock:
    """`VAR_INPUT CONSTANT … END_VAR`."""

    section: str
    """VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_GLOBAL, VAR_TEMP, VAR_STAT, VAR_INST,
    VAR_EXTERNAL, VAR_CONFIG, VAR_GENERIC."""
    qualifiers: tuple[str, ...]
    """CONSTANT, RETAIN, NON_RETAIN, PERSISTENT, and access words."""
    variables: tuple[Declaration, ...]
    note: Note
    at: int = place()
