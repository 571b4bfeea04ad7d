"""Section compensation and phasing, 0x4200 + ID (002 §6.4.4.3)."""

from typing import Any

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import carry_out, function
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands
from achse.motion.commands import Compensation

_ROWS = named_rows(0x4200)


def _start(axis: Axis, request: Any) -> None:
    """Start without an answer: the warning is the result, the compensation runs nevertheless."""
    code, done = commands.start_superposition(axis, Compensation(*request))
    carry_out(code or done.warning)


def _start_with_feedback(axis: Axis, request: Any) -> Compensation:
    code, done = commands.start_superposition(axis, Compensation(*request))
    carry_out(code)
    return done


SUPERPOSITION = (
    bound(_ROWS["start_superposition"], write=_start, non_finite=True),
    bound(
        _ROWS["start_superposition_with_feedback"], exchange=_start_with_feedback, non_finite=True
    ),
    function(_ROWS["stop_superposition"], commands.stop_superposition),
    function(_ROWS["start_phasing"], commands.start_phasing),
)
