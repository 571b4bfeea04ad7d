"""Errors of an axis, as exception types that name the axis and the NC's code.

AdsError
└── AxisError           base: code (0 where the NC gave none) and axis
    ├── AxisRefused     the NC refused a command or a value; nothing has changed (a DeviceError too)
    ├── AxisFailed      the axis is in error
    ├── AxisAborted     a command ended before it was done: stopped, or another one took over
    ├── AxisDisabled    the axis lost its enables, or never had them
    ├── AxisTimeout     the expected state was not reached in time; the axis continues
    └── UnknownAxis     no axis has that id or name
"""

from achse.ams import DeviceError
from achse.ams.errors import CodedError, describe_code


class AxisError(CodedError):
    """An axis did not do what it was asked to.

    `code` is the NC's error code (0x4000 …) or 0, `axis` the name of the axis, `context` says what
    happened, for people.
    """

    def __init__(self, code: int, axis: str, context: str = "") -> None:
        super().__init__(code, context)
        self.axis = axis
        self.args = (self.code, axis, context)

    def __str__(self) -> str:
        parts = [self.axis, self.context, describe_code(self.code) if self.code else ""]
        return ": ".join(filter(None, parts))


class AxisRefused(AxisError, DeviceError):
    """The NC refused a command or a value; the axis does what it did before."""

    def __str__(self) -> str:
        what = ", ".join(filter(None, (self.axis, self.context)))
        return f"{what}: {describe_code(self.code)}"


class AxisFailed(AxisError):
    """The axis is in its error state; `reset` leaves it."""


class AxisAborted(AxisError):
    """A command ended before it was done: it was stopped, or another command took over."""


class AxisDisabled(AxisError):
    """The axis has no enable, or lost it."""


class AxisTimeout(AxisError):
    """The expected state was not reached in time. The axis continues its present command."""


class UnknownAxis(AxisError):
    """No axis of the NC has that id or name."""
