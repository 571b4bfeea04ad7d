"""Commands in layers: parameters, zero points, external set points, several cams and masters.

Operators rarely do this on the fly, and all of it is allowed: each changes something below a motion
that goes on.
"""

from collections.abc import Callable, Sequence

from achse.client.nc.services import CYCLIC, FUNCTIONS, PARAMETERS
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Act, DrawnAxis

LEAST_PART = 0.3
"""Least part of its dynamics that an axis gets by a new parameter."""

_DYNAMICS = (
    "max_acceleration", "max_deceleration", "default_acceleration", "default_deceleration",
    "default_jerk", "max_velocity",
)  # fmt: skip


def layered(draws: Stream, part: DrawnAxis) -> dict[str, float]:
    """Draw the parameters of an axis that say what may be on top of what."""
    values = part.values
    more = {
        "couple_slaves_by_actual_values": int(draws.chance(0.1)),
        "error_reaction_mode": int(draws.chance(0.2)),
        "fading_acceleration": draws.choice((0.0, 0.0, values["max_acceleration"])),
        "allow_motion_commands_with_external_setpoint": int(draws.chance(0.5)),
    }
    if draws.chance(0.15):
        more["encoder_modulo_tolerance_window"] = draws.rounded(0.02 * values["max_velocity"])
    return {**values, **more}


class _Layers:
    """Draws the calls of one act."""

    def __init__(self, draws: Stream, axes: Sequence[DrawnAxis], cams: int) -> None:
        self.draws = draws
        self.cams = cams
        self.axis = draws.randrange(len(axes)) + 1
        self.other = draws.randrange(len(axes)) + 1
        self.third = draws.randrange(len(axes)) + 1
        self.values = axes[self.axis - 1].values
        self.later_ns = 0
        self.calls: list[tuple[int, list[object]]] = []

    def call(self, name: str, *numbers: float, group: int = FUNCTIONS) -> None:
        self.calls.append((self.later_ns, [group, name, self.axis, list(numbers)]))

    def wait(self, longest_s: float) -> None:
        self.later_ns += self.draws.randrange(1, round(longest_s * 1000) + 1) * 1_000_000

    def way(self) -> float:
        draws, top = self.draws, self.values["max_velocity"]
        return draws.rounded(draws.uniform(-1.0, 1.0) * top * draws.decades(-2.0, 0.3))

    def parameter(self) -> None:
        draws = self.draws
        name = draws.choice(_DYNAMICS)
        value = draws.rounded(self.values[name] * draws.uniform(LEAST_PART, 1.0))
        self.call(name, value, group=PARAMETERS)
        if draws.chance(0.5):
            self.wait(1.0)
            self.call(name, self.values[name], group=PARAMETERS)

    def position(self) -> None:
        self.call("set_actual_position", self.draws.choice((1, 2, 3, 4, 5)), self.way())

    def position_on_the_fly(self) -> None:
        self.call("set_actual_position_on_the_fly", self.draws.choice((1, 2)), 0, self.way())

    def external(self) -> None:
        """Let the external interface lead, mostly with a constant set point."""
        draws = self.draws
        if draws.chance(0.3):
            velocity = 0.0 if draws.chance(0.5) else self.way()
            numbers = (self.way(), velocity, 0.0, 0)
            self.call("external_setpoint", *numbers, group=CYCLIC)
        self.call("start_external_setpoint", draws.choice((1, 2)), self.way())
        self.wait(1.0)
        draws.choice(
            (
                lambda: self.call("stop_external_setpoint"),
                lambda: self.call("external_setpoint", 0.0, 0.0, 0.0, 0, group=CYCLIC),
                lambda: None,
            )
        )()

    def cam(self) -> None:
        draws = self.draws
        if self.cams:
            self.call(
                "couple_solo_table",
                *(draws.choice((10, 11, 11)), self.other, 0, 0, draws.randrange(self.cams) + 1),
                *(draws.choice((0, 0, 2)), self.way(), self.way(), self.factor()),
                *(draws.choice((1.0, draws.uniform(0.2, 3.0))), draws.randrange(2)),
                *(draws.randrange(2), draws.randrange(8), self.way(), 0, 0),
            )

    def factor(self) -> float:
        return self.draws.rounded(self.draws.uniform(-2.0, 2.0))

    def cam_scaling(self) -> None:
        draws = self.draws
        self.call(
            "change_table_scaling",
            *(draws.randrange(10), self.way(), draws.randrange(3), draws.randrange(3), self.way()),
            *(self.way(), draws.rounded(draws.uniform(0.2, 3.0)), self.factor()),
        )

    def correction(self) -> None:
        if self.cams:
            name = self.draws.choice(("activate_correction_table", "deactivate_profile_table"))
            self.call(name, self.draws.randrange(self.cams) + 1)

    def several(self) -> None:
        """Follow up to three masters at once, by ratios of the cyclic interface."""
        draws, values = self.draws, self.values
        rise, fall = (draws.rounded(values["max_acceleration"] * draws.random()) for _ in range(2))
        self.ratios()
        self.call(
            "couple",
            *(draws.choice((17, 100)), self.other, 0, 0, self.third, 0, 0, 0, 0, 0, 0, 0, rise),
            *(0, 0, fall, 0.0, 0.0, 0.0, 0.0),
        )
        for _ in range(draws.randrange(1, 4)):
            self.wait(1.0)
            self.ratios()

    def cyclic_gear(self) -> None:
        draws = self.draws
        self.ratios()
        self.call("couple", 15, self.other, 0, 0, draws.decades(-1.0, 2.0), 0.0, 0.0, 0.0)
        self.wait(1.0)
        self.ratios()

    def ratios(self) -> None:
        numbers = [self.draws.rounded(self.draws.uniform(-1.0, 1.0)) for _ in range(4)]
        self.calls.append((self.later_ns, [self.axis, numbers]))

    def switch(self) -> None:
        self.call(self.draws.choice(("clear", "disable", "enable", "reset")))

    def freeze(self) -> None:
        self.call("freeze_override")

    def homed(self) -> None:
        self.call("set_homed_flag", self.draws.randrange(2))

    def phasing(self) -> None:
        draws = self.draws
        velocity = draws.rounded(self.values["max_velocity"] * draws.random())
        numbers = (1, 0, self.other, self.way(), velocity, 0.0, 0.0, 0.0, 0, 0.0)
        self.call("start_phasing", *numbers)


_COMMANDS: Sequence[Callable[[_Layers], None]] = (
    _Layers.parameter, _Layers.parameter, _Layers.position, _Layers.position_on_the_fly,
    _Layers.external, _Layers.external, _Layers.cam, _Layers.cam, _Layers.cam_scaling,
    _Layers.correction, _Layers.several, _Layers.switch, _Layers.freeze, _Layers.homed,
    _Layers.phasing,
    _Layers.cyclic_gear,
)  # fmt: skip


def draw_layers(
    draws: Stream, axes: Sequence[DrawnAxis], cams: int, moments: Sequence[int]
) -> list[Act]:
    """Draw commands in layers, by the first client."""
    acts: list[Act] = []
    for moment in moments:
        layers = _Layers(draws, axes, cams)
        draws.choice(_COMMANDS)(layers)
        for later, values in layers.calls:
            acts.append(Act(moment + later, 0, "ratios" if len(values) == 2 else "nc", values))
    return acts
