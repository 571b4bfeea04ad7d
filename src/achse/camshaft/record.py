"""The records of a camshaft controller and of its cams, as the kernel sees them."""

from achse.camshaft.image import CamInput
from achse.native.declare import Slot, lay_out

LONGEST_WINDOW = 64
"""Cycles over which the speed can be measured."""


class CamControllerFields:
    """A controller with its encoder. Angles are in 0.1 degree, times in ns by default."""

    # parameters, as the rows have them
    active: int = 1
    reversed: int = 0
    encoder_monitoring: int = 0
    shaft_monitoring: int = 0
    rate_monitoring: int = 0
    coupled: int = 0
    encoder_error: int = 0
    shaft_error: int = 0
    rate_error: int = 0
    rate_tolerance: int = 0
    rate_time: int = 0
    actual_rate: int = 0
    set_rate: int = 0
    shaft_time: int = 0
    or_mask: int = 0
    and_mask: int = 0xFFFF_FFFF
    counters: list[int] = [0] * 5
    configured_cams: int = 0
    zero_point: int = 0
    position_offset: int = 0
    box_address: int = 1

    # what it is made for
    increments: float = 4096.0
    """Of a turn."""
    span: float = 0.0
    """After so many increments the encoder begins again at 0; 0: it does not."""
    largest_step: float = 2048.0
    """More increments in a cycle are a jump."""
    cycle_ns: int = 1_000_000
    window: int = 10
    """Cycles over which the speed is measured."""
    and_mask_linked: int = 0
    """True if an AND mask of 0 in the inputs counts."""

    # inputs
    inputs: list[int] = [0] * len(CamInput)
    seen: list[int] = [0] * len(CamInput)
    """The inputs of the cycle before."""
    position: float = 0.0
    """Of the encoder, in increments."""
    valid: int = 1

    # state
    raw: int = 0
    angle: float = 0.0
    known: int = 0
    """True if there was a position."""
    last: float = 0.0
    """The position before."""
    sign: int = 1
    """-1: the angle falls while the encoder counts up."""
    reference: int = 0
    """Zero point and offset of the cycle before."""
    fresh: int = 1
    """True if the angle begins with this cycle: nothing was passed."""
    step: float = 0.0
    """Rotation of the shaft in this cycle, 0.1 degree."""
    speed: float = 0.0
    """0.1 degree per s."""
    speed_before: float = 0.0
    direction: int = 1
    travel: float = 0.0
    """Increments since the start."""
    history: list[float] = [0.0] * LONGEST_WINDOW
    recorded: int = 0
    slot: int = 0
    way: float = 0.0
    """From the 0° of the last stroke on."""
    turned: int = 0
    """True if the shaft has moved since `way` is known."""
    strokes: int = 0
    """Begun in this cycle."""
    stopped_at: float = 0.0
    still_ns: int = 0
    deviating_ns: int = 0
    io_errors: int = 0
    outputs: int = 0


class CamStateFields:
    """A cam."""

    type: int = 0
    start: int = 0
    end: int = 0
    track: int = 0
    dead_time: int = 0
    count: int = 1
    hysteresis: int = 0
    duration: int = 1
    end_value: int = 0
    forward: int = 1
    backward: int = 1
    dynamic: int = 0
    load: int = 0
    hysteresis_on: int = 0
    brake_enabled: int = 0
    force: int = 0
    cycles_on: int = 2

    known: int = 0
    """True if the cam was calculated in the cycle before."""
    heading: int = 1
    """Direction, as far as the hysteresis lets it see."""
    back: float = 0.0
    """Distance of the shaft behind the place that the cam sees."""
    place: float = 0.0
    """The angle that counts for the cam, lead included."""
    before: float = 0.0
    """The same in the cycle before."""
    moved: float = 0.0
    """Movement of `place` in this cycle."""
    way: float = 0.0
    turned: int = 0
    stroke: int = 0
    """From 0 on."""
    begun: int = 0
    """Strokes that began in this cycle."""
    latched: int = 0
    remaining_ns: int = 0
    on: int = 0


CONTROLLER = lay_out("CamControllerFields", [CamControllerFields], Slot)
CAM = lay_out("CamStateFields", [CamStateFields], Slot)
