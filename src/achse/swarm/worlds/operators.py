"""Commands of operators: moves, halts, stops, overrides, jogs, resets, gears and cams at random."""

from collections.abc import Callable, Sequence

from achse.client.nc.services import CYCLIC, FUNCTIONS
from achse.codes.axis import BufferMode, StartType
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Act, DrawnAxis

_POSITIONS = (
    StartType.ABSOLUTE, StartType.ABSOLUTE, StartType.RELATIVE, StartType.RELATIVE,
    StartType.ADDITIVE, StartType.MODULO_SHORTEST, StartType.MODULO_POSITIVE,
    StartType.MODULO_NEGATIVE,
)  # fmt: skip
_ENDLESS = (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE)
_JOGS = tuple(kind + way for kind in (0x110, 0x120, 0x210, 0x310, 0x420, 0x520) for way in (0, 1))
_OVERRIDES = (0, 1000, 250_000, 500_000, 990_000, 1_000_000, 1_000_000, 1_000_000)
_MODES = (0, 0, 0, *BufferMode)


class _Operator:
    """Draws the commands of one act."""

    def __init__(self, draws: Stream, axes: Sequence[DrawnAxis], cams: int) -> None:
        self.draws = draws
        self.cams = cams
        self.axes = axes
        self.axis = draws.randrange(len(axes)) + 1
        self.part = axes[self.axis - 1]
        self.top = self.part.values["max_velocity"]
        others = [n for n in range(1, len(axes) + 1) if n != self.axis]
        self.other = draws.choice(others) if others else 0
        self.later_ns = 0
        """Time of the next commands after the act."""
        self.calls: list[tuple[int, list[object]]] = []

    def call(self, name: str, *numbers: float) -> None:
        self.calls.append((self.later_ns, [FUNCTIONS, name, self.axis, list(numbers)]))

    def set(self, name: str, number: float) -> None:
        self.calls.append((self.later_ns, [CYCLIC, name, self.axis, [number]]))

    def wait(self, longest_s: float) -> None:
        self.later_ns += self.draws.randrange(1, round(longest_s * 1000) + 1) * 1_000_000

    def velocity(self) -> float:
        draws = self.draws
        return draws.rounded(self.top * draws.choice((1.0, draws.uniform(0.1, 1.0))), 3) * 0.999

    def position(self) -> float:
        draws = self.draws
        share = draws.uniform(-1.0, 1.0)
        return draws.rounded(share**3 * self.top * draws.decades(-2.0, 0.3))

    def dynamics(self) -> tuple[float, float, float]:
        draws, values = self.draws, self.part.values
        if draws.chance(0.7):
            return 0.0, 0.0, 0.0
        return (
            draws.rounded(values["max_acceleration"] * draws.uniform(0.2, 0.999)),
            draws.rounded(values["max_deceleration"] * draws.uniform(0.2, 0.999)),
            draws.rounded(values["default_jerk"] * draws.uniform(self.part.gentlest, 0.999)),
        )

    def start(self) -> None:
        draws = self.draws
        kind = draws.choice(_POSITIONS + _ENDLESS)
        position = self.position()
        if kind > StartType.ABSOLUTE_INTERNAL:
            position = draws.rounded(
                draws.uniform(0.0, 0.99) * self.part.values["encoder_modulo_factor"]
            )
        mode = int(draws.choice(_MODES))
        self.call(
            "universal_axis_start",
            *(int(kind), 0, position, self.velocity(), *self.dynamics(), mode, 0.0, 0.0, 0.0),
        )

    def halt(self) -> None:
        kind = self.draws.choice((StartType.HALT, StartType.HALT, StartType.STOP_AND_LOCK))
        self.call(
            "universal_axis_start", int(kind), 0, 0.0, 0.0, *self.dynamics(), 0, 0.0, 0.0, 0.0
        )

    def jog(self) -> None:
        kind = self.draws.choice(_JOGS)
        self.call(
            "universal_axis_start",
            *(kind, 0, 0.0, self.velocity(), 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0),
        )

    def stop(self) -> None:
        self.call("stop")

    def parameterized_stop(self) -> None:
        values = self.part.values
        self.call("parameterized_stop", values["default_deceleration"], values["default_jerk"])

    def emergency_stop(self) -> None:
        values = self.part.values
        self.call("emergency_stop", values["max_deceleration"], values["default_jerk"])

    def new_target(self) -> None:
        self.call("new_end_position", self.draws.choice((1, 1, 2)), self.position())

    def new_dynamics(self) -> None:
        dynamics = self.dynamics()
        if dynamics[0]:
            self.call("new_dynamics", *dynamics)

    def override(self) -> None:
        self.set("velocity_override", self.draws.choice(_OVERRIDES))

    def reset(self) -> None:
        self.call("reset")

    def release(self) -> None:
        self.call("release_motion_lock")

    def enables(self) -> None:
        self.set("control_dword", self.draws.choice((0, 1, 3, 5, 7, 7, 7)))

    def error(self) -> None:
        self.call("set_external_axis_error", 0x4FFF)

    def set_position(self) -> None:
        self.call("set_actual_position", 1, self.position())

    def home(self) -> None:
        self.call("home")

    def superpose(self) -> None:
        draws, values = self.draws, self.part.values
        length = draws.rounded(abs(self.position()) + 0.01 * self.top)
        self.call(
            "start_superposition",
            *(
                draws.randrange(1, 5),
                draws.rounded(0.5 * values["max_acceleration"]),
                draws.rounded(0.5 * values["max_acceleration"]),
                draws.rounded(self.velocity() * draws.random()),
                self.top,
                draws.rounded(length * draws.uniform(-0.5, 0.5)),
                length,
            ),
        )

    def stop_superposition(self) -> None:
        self.call("stop_superposition")

    def couple(self) -> None:
        ratio = self.draws.rounded(self.draws.choice((1.0, -1.0, 0.5, self.draws.uniform(-2, 2))))
        if self.other:
            self.call("couple", 1, self.other, 0, 0, ratio, 0.0, 0.0, 0.0)

    def ratio(self) -> None:
        self.call("change_coupling_parameters", self.draws.uniform(-2.0, 2.0), 0.0, 0.0, 0.0)

    def decouple(self) -> None:
        self.call("decouple")

    def cam(self, activation: int = 0) -> None:
        draws = self.draws
        if self.other and self.cams:
            self.call(
                "couple_solo_table",
                *(draws.choice((10, 11)), self.other, 0, 0, draws.randrange(self.cams) + 1),
                *(draws.choice((0, 0, 2)), 0.0, draws.choice((0.0, self.position())), 1.0, 1.0),
                *(draws.randrange(2), draws.randrange(2), activation, 0.0, 0, 0),
            )

    def coupled_run(self) -> None:
        """Stop both axes, couple them, and change the coupling while the master moves."""
        if not self.other:
            return
        draws, slave = self.draws, self.axis
        for axis in (slave, self.other):
            self.axis = axis
            self.call("reset")
            self.call("stop")
        self.wait(2.0)
        self.axis = slave
        (self.cam if draws.chance(0.7) else self.couple)()
        self.axis = self.other
        self.top, top = self.axes[self.other - 1].values["max_velocity"], self.top
        self.part, part = self.axes[self.other - 1], self.part
        self.start()
        self.axis, self.top, self.part = slave, top, part
        for _ in range(draws.randrange(1, 4)):
            self.wait(1.5)
            draws.choice(
                (
                    lambda: self.cam(draws.randrange(8)),
                    lambda: self.cam(draws.randrange(8)),
                    self.scaling,
                    self.offsets,
                    self.ratio,
                    self.decouple,
                )
            )()

    def scaling(self) -> None:
        self.call("set_slave_table_scaling", self.draws.uniform(-2.0, 2.0))

    def offsets(self) -> None:
        self.call("change_table_coupling_offsets", self.position(), self.position())


_COMMANDS: Sequence[tuple[float, Callable[[_Operator], None]]] = (
    (30.0, _Operator.start),
    (6.0, _Operator.halt),
    (3.0, _Operator.jog),
    (3.0, _Operator.stop),
    (2.0, _Operator.parameterized_stop),
    (2.0, _Operator.emergency_stop),
    (5.0, _Operator.new_target),
    (2.0, _Operator.new_dynamics),
    (6.0, _Operator.override),
    (2.0, _Operator.enables),
    (1.0, _Operator.error),
    (1.0, _Operator.set_position),
    (1.0, _Operator.home),
    (2.0, _Operator.superpose),
    (1.0, _Operator.stop_superposition),
    (2.0, _Operator.couple),
    (1.0, _Operator.ratio),
    (1.0, _Operator.decouple),
    (1.0, _Operator.cam),
    (1.0, _Operator.scaling),
    (1.0, _Operator.offsets),
    (4.0, _Operator.coupled_run),
)
"""Commands with their weights."""


def draw_motion(
    draws: Stream, at_ns: int, actor: int, axes: Sequence[DrawnAxis], cams: int
) -> list[Act]:
    """Draw a command of an operator; often what held the axis before is first cleared away."""
    operator = _Operator(draws, axes, cams)
    if draws.chance(0.15):
        operator.reset()
        operator.release()
        operator.set("control_dword", 7)
    ((_, command),) = draws.choices(_COMMANDS, [weight for weight, _ in _COMMANDS])
    command(operator)
    return [Act(at_ns + later, actor, "nc", values) for later, values in operator.calls]
