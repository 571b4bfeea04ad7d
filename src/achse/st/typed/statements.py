"""The typed form: statements."""

from enum import Enum
from typing import Any, TypeAlias

from achse.iec.structs import StructType
from achse.st.syntax.nodes import node, place
from achse.st.typed.expressions import Stored, TypedValue
from achse.st.typed.places import Storage


@node
class Do:
    """Evaluate and drop the value: assignments, calls."""

    value: TypedValue
    at: int = place()


@node
class TypedBranch:
    """A condition (BOOL) and its statements."""

    condition: TypedValue
    body: "TypedStatements"
    at: int = place()


@node
class Conditional:
    """IF, ELSIF, ELSE."""

    branches: tuple[TypedBranch, ...]
    otherwise: "TypedStatements"
    at: int = place()


@node
class TypedChoice:
    """Labels of a CASE as inclusive ranges `(low, high)`, in the type of the selector."""

    labels: tuple[tuple[int, int], ...]
    body: "TypedStatements"
    at: int = place()


@node
class CaseSelection:
    """CASE: the first choice that has the selector's value; none: `otherwise`. No fall-through."""

    selector: TypedValue
    """Selector of an IntegerType; a BOOL selector is converted before."""
    choices: tuple[TypedChoice, ...]
    otherwise: "TypedStatements"
    at: int = place()


@node
class CountedLoop:
    """FOR.

    1 `start` (assigns the counter). 2 evaluate `beyond`, leave if TRUE. 3 body. 4 `advance`
    (counter := counter + step, in the counter's own type). 5 to 2. CONTINUE goes to 4. The end and
    the step are evaluated on every pass, as on real targets; all of that is in the values here.
    """

    start: Stored
    beyond: TypedValue
    """BOOL: counter > end, for a step below 0 counter < end."""
    advance: Stored
    body: "TypedStatements"
    at: int = place()


@node
class ConditionLoop:
    """WHILE (`before`) and REPEAT: goes on while `condition` is TRUE (UNTIL comes negated).

    CONTINUE goes to the test, in both.
    """

    condition: TypedValue
    body: "TypedStatements"
    before: bool
    at: int = place()


@node
class Protected:
    """__TRY. On an exception in `body`: its code into `code` (if there is one), then `handler`;
    `final` in any case. Without a handler (`has_handler` FALSE) it goes on after `final`."""

    body: "TypedStatements"
    code: Storage | None
    handler: "TypedStatements"
    final: "TypedStatements"
    has_handler: bool
    at: int = place()


@node
class LoopExit:
    """EXIT: leaves the innermost loop."""

    at: int = place()


@node
class LoopNext:
    """CONTINUE."""

    at: int = place()


@node
class RoutineExit:
    """RETURN."""

    at: int = place()


@node
class JumpTo:
    """JMP. The mark is in the same list of statements or in one around it."""

    label: str
    """Label in lower case."""
    at: int = place()


@node
class JumpMark:
    """`label:`; marks that nothing jumps to are left out."""

    label: str
    at: int = place()


class LifeEvent(Enum):
    """Event in the life cycle of a record."""

    CREATE = "CREATE"
    """Write the header (of a block), run `create` with `arguments`, do `values`, run `after_init`.
    """
    EXIT = "EXIT"
    """Run `exit` with `arguments`."""
    REINIT = "REINIT"
    """Run `reinit`: after the values were copied in an online change."""


@node
class LifeStep:
    """Run the life cycle of one record, or of `count` of them `stride` bytes apart, in order.

    `create`, `exit`, `reinit` and `after_init` are routines of `of`'s row in
    `TypedProject.blocks` or `records`. The bytes are at their initial values before CREATE.
    """

    event: LifeEvent
    storage: Storage
    of: StructType[Any]
    count: int
    stride: int
    arguments: tuple[Stored, ...]
    """Parameters of the routine, stored into `CalleeBase`: bInitRetains and bInCopyCode, then
    what FB_init has more."""
    values: "TypedStatements"
    """Statements for the values that the declaration sets; empty if `count` is not 1."""
    at: int = place()


TypedStatement: TypeAlias = (
    Do
    | Conditional
    | CaseSelection
    | CountedLoop
    | ConditionLoop
    | Protected
    | LoopExit
    | LoopNext
    | RoutineExit
    | JumpTo
    | JumpMark
    | LifeStep
)

TypedStatements: TypeAlias = tuple[TypedStatement, ...]
