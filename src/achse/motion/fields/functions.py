"""Fields that axis functions write: switches and injected errors."""

from achse.motion.fields.declare import Inputs, flag, whole


class FunctionInput(Inputs):
    """Switches set by functions (002 §6.4.4.3, 0x4200 + ID)."""

    axis_disabled: int = flag(0, "whole axis is deactivated (function 0x50)")
    drive_output_disabled: int = flag(0, "drive output is switched off (function 0x60)")
    brake_released: int = flag(0, "the parking brake stays released (function 0x62)")
    external_error: int = whole(0, "NcError", "error injected from outside (function 0x19)")
