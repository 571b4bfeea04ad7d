"""One routine while it is being checked: what its parts share."""

from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec.elementary import BOOL, INT, BoolType
from achse.iec.structs import StructType
from achse.st.check.arguments import ArgumentBinder
from achse.st.check.assignments import Assignments
from achse.st.check.builtins import Builtins
from achse.st.check.calls import CallChecker
from achse.st.check.checks import ImplicitChecks
from achse.st.check.conversions import Converter, converted
from achse.st.check.elements import Elements
from achse.st.check.expressions import ExpressionChecker
from achse.st.check.initials import Initials
from achse.st.check.names import NameResolver
from achse.st.check.operands import TypedOperand
from achse.st.check.operators import Operators
from achse.st.check.paths import Paths
from achse.st.check.signatures import Signature
from achse.st.check.statements import StatementChecker
from achse.st.check.system import SystemOperators
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.typed.expressions import TypedValue
from achse.st.typed.places import FrameBase, Storage
from achse.st.typed.project import Routine, RoutineKind
from achse.st.typed.statements import TypedStatement

if TYPE_CHECKING:
    from achse.st.check.checking import Checking


class RoutineBody:
    """Everything about one routine: its signature and frame, and one object for each concern."""

    def __init__(self, checking: "Checking", signature: Signature) -> None:
        self.checking = checking
        self.signature = signature
        self.frame = signature.frame
        self.scope = signature.scope
        self.this: StructType[Any] | None = signature.this
        self.failed = False
        self.converter = Converter(self.warn, checking.blocks.implements)
        self.names = NameResolver(self)
        self.paths = Paths(self)
        self.elements = Elements(self)
        self.operators = Operators(self)
        self.builtins = Builtins(self)
        self.system = SystemOperators(self)
        self.calls = CallChecker(self)
        self.arguments = ArgumentBinder(self)
        self.checks = ImplicitChecks(self)
        self.assignments = Assignments(self)
        self.expressions = ExpressionChecker(self)
        self.statements = StatementChecker(self)
        self.initials = Initials(self)
        self.life = checking.life

    @property
    def source(self) -> Source:
        return self.signature.source

    def note_use(self, tree: Any, whole: Any, meaning: Any) -> None:
        """Keep the meaning of a name for an editor."""
        from achse.st.check.checking import NameUse  # each needs the other

        if self.checking.uses is not None:
            self.checking.uses.append(NameUse(self, tree, whole, meaning))

    # faults ---------------------------------------------------------------------------------

    def warn(self, at: int, message: str, code: Code) -> None:
        """Keep a warning; those about libraries are not the user's."""
        if not self.signature.entry.is_library:
            self.checking.warn(self.source, at, message, code)

    def fault(self, at: int, message: str, code: Code) -> None:
        """Keep a fault; the routine cannot run."""
        self.failed = True
        self.checking.fault(self.source, at, message, code)

    def missing_in_out(self, signature: Signature, name: str, at: int) -> None:
        """Report a VAR_IN_OUT without an argument."""
        raise Unexpected(
            at, f"{signature.name} is called without its VAR_IN_OUT {name}", Code.IN_OUT_ARGUMENT
        )

    # what several parts need -----------------------------------------------------------------

    def truth(self, operand: TypedOperand, at: int) -> TypedValue:
        """Return a BOOL. Raises `Unexpected` for anything else."""
        if isinstance(operand.flat, BoolType):
            return operand.value
        if operand.loose and operand.constant in (0, 1):
            return self.converter.implicit(operand, BOOL, at)
        raise Unexpected(at, f"expected a BOOL, got a {operand.type.name}", Code.BOOL_EXPECTED)

    def widened(self, operand: TypedOperand, at: int) -> TypedOperand:
        """Return a plain whole number at the type it has by itself: INT at least."""
        if operand.flat.size >= INT.size:
            return operand
        return TypedOperand(converted(operand.value, INT, at), INT)

    def check_writable(self, operand: TypedOperand, at: int) -> None:
        """Raise `Unexpected` for constants."""
        storage = operand.storage
        if storage is not None and storage.is_constant:
            raise Unexpected(
                at,
                f"{storage.name} is CONSTANT: nothing can be assigned to it",
                Code.NOT_ASSIGNABLE,
            )
        if operand.outside:
            self.warn(
                at,
                f"{operand.outside} is not an input: only its block should write it",
                Code.OUTSIDE_WRITE,
            )

    def mark_addressed(self, storage: Storage) -> None:
        """Note that a variable of the frame needs memory."""
        if isinstance(storage.base, FrameBase):
            self.frame.addressed.add(storage.name.partition(".")[0].partition("[")[0].lower())


class CheckedRoutine(NamedTuple):
    """A body after it was checked."""

    body: RoutineBody
    opening: tuple[TypedStatement, ...]
    statements: tuple[TypedStatement, ...] | None
    builtin: bool

    def routine(self) -> Routine:
        """Return the typed form. Its frame is complete only when all callers are, too."""
        body, signature = self.body, self.body.signature
        owner = "" if signature.kind is RoutineKind.FUNCTION else signature.entry.name.lower()
        parameters = []
        if signature.kind not in (RoutineKind.BODY, RoutineKind.PROGRAM):  # those have a frame
            for parameter in signature.parameters:
                parameters += [parameter.variable, *parameter.bounds]
        addressed = set(body.frame.addressed)
        addressed |= {
            variable.name.lower()
            for variable in body.frame.variables
            if variable.type.is_view or variable.type.size > 8
        }
        return Routine(
            signature.key,
            signature.name,
            signature.kind,
            owner,
            signature.source,
            signature.tree.at,
            signature.this,
            tuple(parameters),
            signature.result or signature.nothing,
            body.frame.structure(),
            self.opening,
            self.statements,
            self.builtin,
            frozenset(addressed),
        )
