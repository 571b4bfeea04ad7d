"""[[terminal]] of station.toml: virtual terminals on a bus, and the bytes of a PLC they are at.

A terminal is digital or analog, or with `esi` any device of a vendor's ESI file.
"""

from typing import Literal

from pydantic import Field, model_validator

from achse.station.configuration.types import ConfigTable

_DIGITAL, _ANALOG = 64, 8
_LAST_ADDRESS = 0xFFFF


class TerminalConfig(ConfigTable):
    """[[terminal]]: a terminal on a bus, alone or beside drives."""

    name: str = Field(min_length=1, max_length=31)
    kind: Literal["digital", "analog"] = "digital"
    bus: str | None = None
    """Name of the bus; not needed if there is one."""
    position: int | None = Field(default=None, ge=1, le=255)
    """Place along the cable, the first is 1; without it the next free one, behind the drives."""
    inputs: int | None = Field(default=None, ge=0, le=_DIGITAL)
    """Channels; 16 digital or 4 analog unless given."""
    outputs: int | None = Field(default=None, ge=0, le=_DIGITAL)
    """Channels; 16 digital or 4 analog unless given."""
    esi: str | None = Field(default=None, min_length=1)
    """An ESI file, or a folder of them (relative to the station.toml): the terminal is the device
    named `type` of them."""
    type: str | None = Field(default=None, min_length=1)
    """Type of the device in the ESI file, TYPE or TYPE@REVISION."""
    modules: list[str] = Field(default_factory=list, max_length=255)
    """Modules in the slots of the device, by their names in the ESI file."""
    behaviour: str | None = Field(default=None, min_length=1)
    """Behaviour of the device: `loop-back`, a .csv file of recorded inputs, or FILE.py:CLASS
    (relative to the station.toml); without it inputs stay as they were set."""
    plc: int | None = Field(default=None, ge=1, le=65535)
    """Port of the PLC; the first one unless given."""
    input_address: int | None = Field(default=None, ge=0, le=_LAST_ADDRESS)
    """Byte of %I where the inputs begin; without it the PLC does not see them."""
    output_address: int | None = Field(default=None, ge=0, le=_LAST_ADDRESS)
    """Byte of %Q where the outputs begin; without it the PLC does not write them."""

    @model_validator(mode="after")
    def _is_whole(self) -> "TerminalConfig":
        if self.esi is not None:
            besides = {"kind", "inputs", "outputs"} & self.model_fields_set
            if besides:
                raise ValueError(f"{min(besides)}: expected none beside esi, the file says it")
            if self.type is None:
                raise ValueError("type: expected the type of a device of the ESI file")
            return self
        for key in ("type", "modules", "behaviour"):
            if getattr(self, key):
                raise ValueError(f"{key}: expected beside esi")
        most = _DIGITAL if self.is_digital else _ANALOG
        for what, number in (("inputs", self.input_count), ("outputs", self.output_count)):
            if number > most:
                raise ValueError(f"{what}: expected at most {most} {self.kind} channels")
        if not self.input_count + self.output_count:
            raise ValueError("expected inputs or outputs")
        return self

    @property
    def is_digital(self) -> bool:
        """True for bits, False for numbers of 16 bits."""
        return self.kind == "digital"

    @property
    def input_count(self) -> int:
        """Input channels."""
        return self._default if self.inputs is None else self.inputs

    @property
    def output_count(self) -> int:
        """Output channels."""
        return self._default if self.outputs is None else self.outputs

    @property
    def _default(self) -> int:
        return 16 if self.is_digital else 4
