"""Section compensation and phasing, 0x4200 + ID (002 §6.4.4.3)."""

from collections import namedtuple
from typing import Any

from achse.devices.nc.functions.calling import carry_out, function
from achse.devices.nc.layouts import NO_DATA
from achse.motion import Axis, commands
from achse.motion.commands import Compensation
from achse.server import READ_WRITE, WRITE, Layout, Service

__all__ = ["SUPERPOSITION"]

_WITHOUT_WARNING = namedtuple("Compensation", Compensation._fields[:-1])  # type: ignore[misc]


def _start(axis: Axis, asked: Any) -> None:
    """The form without an answer: the warning is its result, the compensation runs all the same."""
    code, done = commands.start_superposition(axis, Compensation(*asked))
    carry_out(code or done.warning)


def _start_with_feedback(axis: Axis, asked: Compensation) -> Compensation:
    code, done = commands.start_superposition(axis, asked)
    carry_out(code)
    return done


_ASKED = (Layout("<I6d", _WITHOUT_WARNING), Layout("<I4x6d", _WITHOUT_WARNING))
_DONE = (Layout("<I6dI", Compensation), Layout("<I4x6dI4x", Compensation))

_PHASING = Layout(
    "<III4x5d36xId",
    namedtuple(
        "Phasing",
        "phasing_type control_mask master_axis_id phase_shift velocity acceleration deceleration "
        "jerk buffer_mode blending_position",
    ),
)

SUPERPOSITION = (
    Service(
        0x30,
        "start_superposition",
        WRITE,
        _ASKED,
        "gain or lose a distance over a way; answers 0x4243 where only a part is possible",
        write=_start,
        non_finite=True,
    ),
    Service(
        0x30,
        "start_superposition_with_feedback",
        READ_WRITE,
        _DONE,
        "gain or lose a distance over a way; answers what is carried out, with its warning",
        exchange=_start_with_feedback,
        response=_DONE,
        non_finite=True,
    ),
    function(
        0x31, "stop_superposition", commands.stop_superposition, NO_DATA, "stop gaining or losing"
    ),
    function(
        0x34, "start_phasing", commands.start_phasing, _PHASING, "shift the phase to the master"
    ),
)
