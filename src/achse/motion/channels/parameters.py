"""Configuration of a channel at the start of the NC."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from achse.gcode.state.mfunctions import MRule
from achse.motion.channels.store import ProgramStore
from achse.motion.channels.technology import M_FUNCTIONS
from achse.motion.groups.parameters import GroupParametersError
from achse.motion.groups.states import ChannelType, InterpreterType


@dataclass(frozen=True, slots=True)
class ChannelParameters:
    """A channel that owns groups of several axes. Raises GroupParametersError."""

    channel_id: int
    name: str = ""
    type: ChannelType = ChannelType.INTERPRETER
    interpreter: InterpreterType = InterpreterType.CLASSIC
    m_rules: Mapping[int, MRule] = field(default_factory=dict)
    """Behaviour of M functions, by number 0..159."""
    store: ProgramStore | None = None
    """Store of its programs and files."""

    def __post_init__(self) -> None:
        if not 1 <= self.channel_id <= 255:
            raise GroupParametersError(f"channel id {self.channel_id}: expected 1..255")
        for number in self.m_rules:
            if not 0 <= number < M_FUNCTIONS:
                raise GroupParametersError(f"M function {number}: expected 0..{M_FUNCTIONS - 1}")
