"""Rare commands of operators: flying saws, cyclic gears, phasing, new targets in motion."""

from collections.abc import Callable, Sequence

from achse.client.nc.services import CYCLIC, FUNCTIONS
from achse.codes.axis import StartType
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Act, DrawnAxis

_MASK = (0, 0, 0, 0x10000, 0x20000, 0x100000, 0x200000, 0x400000, 0x3F)
"""Control masks of a universal flying saw."""


class _RareOperator:
    """Draws the commands of one act."""

    def __init__(self, draws: Stream, axes: Sequence[DrawnAxis]) -> None:
        self.draws = draws
        self.axes = axes
        numbers = list(range(1, len(axes) + 1))
        self.slave, self.master, *others = draws.sample(numbers, len(numbers))
        self.third = others[0] if others else self.master
        self.later_ns = 0
        self.calls: list[tuple[int, list[object]]] = []

    def call(self, axis: int, name: str, *numbers: float) -> None:
        self.calls.append((self.later_ns, [FUNCTIONS, name, axis, list(numbers)]))

    def wait(self, longest_s: float) -> None:
        self.later_ns += self.draws.randrange(1, round(longest_s * 1000) + 1) * 1_000_000

    def top(self, axis: int) -> float:
        return self.axes[axis - 1].values["max_velocity"]

    def way(self, axis: int) -> float:
        draws = self.draws
        return draws.rounded(draws.uniform(-1.0, 1.0) * self.top(axis) * draws.decades(-2.0, 0.3))

    def velocity(self, axis: int) -> float:
        return self.draws.rounded(self.top(axis) * self.draws.uniform(0.05, 0.999))

    def ratio(self) -> float:
        """Return a ratio with which the slave is as fast as it may be, slower, or too fast."""
        draws, share = self.draws, self.top(self.slave) / self.top(self.master)
        if draws.chance(0.2):
            share *= draws.decades(0.0, 1.5)
        return draws.rounded(share * draws.choice((1.0, -1.0)) * draws.random())

    def start(self, axis: int, *, endless: bool = False) -> None:
        kind = StartType.RELATIVE
        if endless:
            kind = self.draws.choice((StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE))
        self.call(
            axis, "universal_axis_start", int(kind), 0, self.way(axis), self.velocity(axis),
            0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0,
        )  # fmt: skip

    def clear(self) -> None:
        """Let both axes come to rest, without errors."""
        for axis in (self.slave, self.master):
            self.call(axis, "decouple")
            self.call(axis, "stop")
        self.wait(2.0)
        for axis in (self.slave, self.master):
            self.call(axis, "reset")
        self.wait(0.1)

    def run_master(self) -> None:
        self.start(self.master, endless=self.draws.chance(0.6))

    def saw_by_parameters(self) -> None:
        draws = self.draws
        places = 0.0, 0.0
        if draws.chance(0.6):
            places = abs(self.way(self.master)), abs(self.way(self.slave))
        self.call(
            self.slave,
            "couple",
            draws.choice((2, 3)),
            self.master,
            0,
            0,
            self.ratio(),
            *places,
            0.0,
        )

    def universal_saw(self) -> None:
        draws, limits = self.draws, (0.0, 0.0, 0.0, 0.0)
        self.call(
            self.slave, "couple_universal_flying_saw", draws.choice((5, 5, 6)), self.master, 0, 0,
            self.ratio(), self.way(self.master), self.way(self.slave), *limits,
            draws.choice(_MASK),
        )  # fmt: skip

    def cyclic_gear(self) -> None:
        share = self.draws.decades(-1.0, 2.0)
        self.call(self.slave, "couple", 15, self.master, 0, 0, share, 0.0, 0.0, 0.0)

    def modulo_flying_saw(self) -> None:
        self.call(
            self.slave, "couple", 12, self.master, 0, 0, self.draws.choice((0, 1, 1, 2)),
            self.third, self.draws.uniform(0.05, 1.0), 0.0,
        )  # fmt: skip

    def bilinear(self) -> None:
        self.call(
            self.slave, "couple", 16, self.master, 0, 0, self.ratio(), self.third, self.ratio(), 0.0
        )

    def saw(self) -> None:
        """Let a slave run with its master, change what it does, and let it go."""
        draws = self.draws
        if draws.chance(0.7):
            self.clear()
        moves_before = draws.chance(0.6)
        if moves_before:
            self.run_master()
            self.wait(1.0)
        if draws.chance(0.3):
            self.start(self.slave)
            self.wait(0.5)
        draws.choice(
            (
                self.saw_by_parameters, self.universal_saw, self.universal_saw, self.universal_saw,
                self.cyclic_gear, self.modulo_flying_saw, self.bilinear,
            )
        )()  # fmt: skip
        if not moves_before:
            self.run_master()
        for _ in range(draws.randrange(1, 5)):
            self.wait(1.0)
            draws.choice(
                (
                    self.phasing, self.phasing, self.change, self.stop_slave, self.let_go,
                    self.universal_saw, self.halt_master, self.run_master, self.start_slave,
                    self.gear_ratio, self.gear_ratio, self.error,
                )
            )()  # fmt: skip

    def phasing(self) -> None:
        draws, master = self.draws, self.master
        self.call(
            self.slave, "start_phasing", draws.choice((1, 2, 2, 4096)), draws.randrange(2), master,
            self.way(master), self.velocity(self.slave), 0.0, 0.0, 0.0, 0, 0.0,
        )  # fmt: skip

    def change(self) -> None:
        values = self.ratio(), abs(self.way(self.master)), abs(self.way(self.slave)), 0.0
        self.call(self.slave, "change_coupling_parameters", *values)

    def gear_ratio(self) -> None:
        self.calls.append((self.later_ns, [CYCLIC, "operation_mode", self.slave, [0]]))
        self.change()

    def stop_slave(self) -> None:
        self.call(self.slave, self.draws.choice(("stop_slave", "stop")))

    def start_slave(self) -> None:
        slave = self.slave
        self.call(
            slave, "decouple_and_universal_axis_start", int(StartType.RELATIVE), 0, self.way(slave),
            self.velocity(slave), 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0,
        )  # fmt: skip

    def halt_master(self) -> None:
        self.call(self.master, self.draws.choice(("stop", "stop", "reset")))

    def error(self) -> None:
        axis = self.draws.choice((self.slave, self.master))
        self.call(axis, "set_external_axis_error", 0x4FFF)

    def let_go(self) -> None:
        slave, kind = self.slave, self.draws.randrange(6)
        self.call(slave, "decouple", kind, self.way(slave), self.velocity(slave), 0.0, 0.0, 0.0)

    def oriented_stop(self) -> None:
        slave = self.slave
        place = self.top(slave) * self.draws.random()
        if self.draws.chance(0.7):
            self.start(slave, endless=True)
            self.wait(1.0)
        self.call(slave, "oriented_stop", self.draws.rounded(place), 0.0, 0.0)

    def new_target(self) -> None:
        """Give a new position and velocity, now or from a place on."""
        draws, slave = self.draws, self.slave
        if draws.chance(0.7):
            self.start(slave)
            self.wait(1.0)
        self.call(
            slave, "new_end_position_and_velocity", draws.randrange(1, 6), draws.choice((1, 1, 2)),
            self.way(slave), self.velocity(slave), self.way(slave),
        )  # fmt: skip

    def special(self) -> None:
        """Start with a first and a last velocity, and a place where it changes."""
        slave = self.slave
        self.call(
            slave, "start_special", int(StartType.RELATIVE), self.way(slave), self.velocity(slave),
            self.way(slave), self.velocity(slave), 1, 0.0, 1, 0.0, 1, 0.0,
        )  # fmt: skip

    def reversing(self) -> None:
        slave = self.slave
        self.call(
            slave, "start_reversing_positioning", int(StartType.ABSOLUTE), self.way(slave),
            self.way(slave), self.velocity(slave), self.draws.choice((0.0, 0.1)),
        )  # fmt: skip
        self.wait(3.0)
        self.draws.choice((self.stop_slave, self.new_target, self.error))()

    def two_parts(self) -> None:
        """Let two commands wait, and change one under way."""
        draws, slave = self.draws, self.slave
        for _ in range(draws.randrange(2, 5)):
            mode = draws.choice((1, 2, 3, 4, 5, 18, 19, 20))
            self.call(
                slave, "universal_axis_start", int(StartType.RELATIVE), 0, self.way(slave),
                self.velocity(slave), 0.0, 0.0, 0.0, mode, 0.0, 0.0, 0.0,
            )  # fmt: skip
            if draws.chance(0.4):
                self.wait(0.5)
        draws.choice((self.stop_slave, self.new_target, self.error, self.oriented_stop))()


_COMMANDS: Sequence[tuple[float, Callable[[_RareOperator], None]]] = (
    (12.0, _RareOperator.saw),
    (2.0, _RareOperator.oriented_stop),
    (3.0, _RareOperator.new_target),
    (2.0, _RareOperator.special),
    (1.0, _RareOperator.reversing),
    (3.0, _RareOperator.two_parts),
)
"""Commands with their weights."""


def draw_rare_motion(
    draws: Stream, axes: Sequence[DrawnAxis], clients: int, moments: Sequence[int]
) -> list[Act]:
    """Draw rare commands to two or more axes, by any client."""
    acts: list[Act] = []
    weights = [weight for weight, _ in _COMMANDS]
    for moment in moments:
        operator = _RareOperator(draws, axes)
        actor = draws.randrange(clients)
        ((_, command),) = draws.choices(_COMMANDS, weights)
        command(operator)
        acts += [Act(moment + later, actor, "nc", values) for later, values in operator.calls]
    return acts
