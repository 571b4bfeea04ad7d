"""Channels of a world: axes on a path, part programs, and commands at any moment."""

from collections.abc import Callable, Sequence

from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Act, DrawnAxis, DrawnChannel

CHANNEL, GROUP = 1, 200
"""Ids of the channel and of its 3D group."""

HANDSHAKE = 40
"""M function that waits for a grant."""

_FULL = 1_000_000
_SECOND = 1_000_000_000

_PARAMETERS, _FUNCTIONS, _CYCLIC, _GROUP = 0x2000, 0x2200, 0x2300, 0x3200


def program_file(number: int) -> str:
    """Return the name of a part program in the folder of the channel."""
    return f"part{number}.nc"


def draw_channel(draws: Stream) -> DrawnChannel | None:
    """Draw a channel with two or three axes and its part programs; most worlds have none."""
    if not draws.chance(0.35):
        return None
    top = draws.decades(1.0, 2.7)
    axes = [_axis(draws, name, top) for name in "XYZ"[: draws.randrange(2, 4)]]
    size = draws.rounded(top * draws.decades(-2.0, 0.0))
    programs = [
        _program(draws, "".join(axis.name for axis in axes), size, top)
        for _ in range(draws.randrange(1, 4))
    ]
    return DrawnChannel(
        axes, programs, draws.chance(0.5), draws.choice((1, 1, 20)), draws.choice((128, 1024))
    )


def _axis(draws: Stream, name: str, top: float) -> DrawnAxis:
    velocity = draws.rounded(top * draws.uniform(0.3, 1.0))
    acceleration = draws.rounded(velocity * draws.decades(0.0, 1.3))
    deceleration = draws.rounded(acceleration * draws.choice((1.0, draws.decades(-0.5, 0.5))))
    jerk = draws.rounded(max(acceleration, deceleration) * draws.decades(0.5, 2.5))
    values: dict[str, float] = {
        "max_velocity": velocity,
        "rapid_traverse_velocity": velocity,
        "jog_velocity_slow": draws.rounded(0.2 * velocity),
        "jog_velocity_fast": velocity,
        "max_acceleration": acceleration,
        "max_deceleration": deceleration,
        "default_acceleration": acceleration,
        "default_deceleration": deceleration,
        "default_jerk": jerk,
        "encoder_modulo_factor": velocity,
        "controller_following_error_position_monitoring_enable": 0,
        "velocity_override": _FULL,
        "control_dword": 7,
    }
    return DrawnAxis(name, "mm", False, values)


def _program(draws: Stream, letters: str, size: float, top: float) -> str:
    """Lines and arcs in absolute positions; arcs are in X and Y, and begin behind a line."""
    lines = [f"F{60.0 * top * draws.uniform(0.1, 1.0):.0f}"]
    if draws.chance(0.6):
        curve, radius = draws.randrange(2, 6), size * draws.decades(-3.0, 0.0)
        lines.append(f"#set paramVertexSmoothing({curve};1;{radius:.4f})#")
    place = dict.fromkeys(letters, 0.0)
    for number in range(1, draws.randrange(3, 25)):
        for letter in letters:
            if draws.chance(0.6):
                place[letter] = round(size * draws.uniform(-1.0, 1.0), 4)
        words = " ".join(f"{letter}{place[letter]:.4f}" for letter in letters)
        kind = draws.choice(("G1", "G1", "G1", "G1", "G0", "arc", "other"))
        if kind == "arc":
            radius = round(size * draws.uniform(0.05, 0.5), 4)
            way = draws.choice(("G2", "G3"))
            lines.append(f"N{number} G1 {words}")
            place["X"] = round(place["X"] + 2.0 * radius, 4)
            lines.append(f"N{number} {way} X{place['X']:.4f} Y{place['Y']:.4f} I{radius:.4f} J0")
        elif kind == "other":
            lines.append(f"N{number} {_other(draws, top)}")
        else:
            lines.append(f"N{number} {kind} {words}")
    return "\n".join([*lines, "M30", ""])


def _other(draws: Stream, top: float) -> str:
    return draws.choice(
        (
            f"F{60.0 * top * draws.uniform(0.05, 1.0):.0f}",
            f"G4 X{draws.choice((0.002, 0.05, 0.3))}",
            f"M{HANDSHAKE}",
            "M7",
            "@714",
            f"DYNOVR={draws.uniform(0.2, 1.0):.2f}",
        )
    )


class _Programmer:
    """Draws the requests of one act on the channel."""

    def __init__(self, draws: Stream, channel: DrawnChannel, first: int) -> None:
        self.draws = draws
        self.channel = channel
        self.ids = list(range(first, first + len(channel.axes)))
        self.later_ns = 0
        self.calls: list[tuple[int, str, list[object]]] = []

    def _call(self, group: int, name: str, value: object = ()) -> None:
        id = GROUP if group == _GROUP else CHANNEL
        self.calls.append((self.later_ns, "channel", [group, id, name, value]))

    def _axis(self, name: str, numbers: Sequence[float], group: int = 0x4200) -> None:
        axis = self.draws.choice(self.ids)
        self.calls.append((self.later_ns, "nc", [group, name, axis, list(numbers)]))

    def load(self) -> None:
        number = self.draws.randrange(len(self.channel.programs))
        self._call(_FUNCTIONS, "load_program_by_name", program_file(number))

    def start(self) -> None:
        self._call(_FUNCTIONS, "start_interpreter")

    def run(self) -> None:
        """Clear all away, and begin a program."""
        for id in self.ids:
            self.calls.append((self.later_ns, "nc", [0x4300, "control_dword", id, [7]]))
            self.calls.append((self.later_ns, "nc", [0x4200, "reset", id, []]))
        self._call(_FUNCTIONS, "reset")
        self._call(_CYCLIC, "channel_velocity_override", [_FULL])
        if self.draws.chance(0.8):
            self._call(_FUNCTIONS, "set_interpreter_operation_mode", [0])
        self.later_ns += 50_000_000
        self.assign()
        self.load()
        self.start()

    def stop(self) -> None:
        self._call(_FUNCTIONS, "stop")

    def reset(self) -> None:
        self._call(_FUNCTIONS, "reset")

    def again(self) -> None:
        self._call(_FUNCTIONS, self.draws.choice(("retry", "skip")))

    def assign(self) -> None:
        self._call(_GROUP, "assign_axes_xyz", [*self.ids, 0, 0][:3])

    def group(self) -> None:
        names = ("stop", "clear", "reset", "step_on", "dissolve_axis_assignment")
        self._call(_GROUP, self.draws.choice(names))

    def emergency_stop(self) -> None:
        axis = self.channel.axes[0].values
        factor = self.draws.decades(-2.0, 3.0)
        deceleration = self.draws.rounded(axis["max_deceleration"] * factor)
        jerk = self.draws.rounded(axis["default_jerk"] * self.draws.decades(-2.0, 3.0))
        self._call(_GROUP, "emergency_stop", [deceleration, jerk])
        self.later_ns += self.draws.choice((2, 50, 1000)) * 1_000_000
        self._call(_GROUP, "step_on")

    def override(self) -> None:
        value = self.draws.choice((0, 1000, 300_000, 700_000, _FULL, _FULL))
        self._call(_CYCLIC, "channel_velocity_override", [value])

    def mode(self) -> None:
        self._call(
            _FUNCTIONS, "set_interpreter_operation_mode", [self.draws.choice((0, 1, 0x4000))]
        )

    def grant(self) -> None:
        self._call(_CYCLIC, "plc_to_nc_written", [self.draws.randrange(3)])

    def delete_distance(self) -> None:
        self._call(_FUNCTIONS, "delete_distance_to_go")

    def retrace(self) -> None:
        self._call(_PARAMETERS, "retrace_enable", [self.draws.randrange(2)])

    def axis(self) -> None:
        """Act on one of its axes alone."""
        draws = self.draws
        draws.choice(
            (
                lambda: self._axis("reset", ()),
                lambda: self._axis("stop", ()),
                lambda: self._axis("set_external_axis_error", (0x4FFF,)),
                lambda: self._axis("control_dword", (draws.choice((0, 3, 5, 7)),), 0x4300),
                lambda: self._axis(
                    "velocity_override", (draws.choice((0, 400_000, _FULL)),), 0x4300
                ),
            )
        )()


_COMMANDS: Sequence[tuple[float, Callable[[_Programmer], None]]] = (
    (10.0, _Programmer.run),
    (3.0, _Programmer.start),
    (1.0, _Programmer.load),
    (1.5, _Programmer.stop),
    (0.5, _Programmer.reset),
    (0.5, _Programmer.again),
    (0.5, _Programmer.assign),
    (1.0, _Programmer.group),
    (3.0, _Programmer.emergency_stop),
    (5.0, _Programmer.override),
    (1.0, _Programmer.mode),
    (3.0, _Programmer.grant),
    (0.5, _Programmer.delete_distance),
    (0.3, _Programmer.retrace),
    (1.0, _Programmer.axis),
)
"""Commands with their weights."""


def draw_channel_acts(
    draws: Stream, channel: DrawnChannel, first: int, clients: int, moments: Sequence[int]
) -> list[Act]:
    """Draw commands to the channel, whose axes have the ids from `first` on, by any client."""
    acts: list[Act] = []
    weights = [weight for weight, _ in _COMMANDS]
    for moment in moments:
        programmer = _Programmer(draws, channel, first)
        actor = draws.randrange(clients)
        ((_, command),) = draws.choices(_COMMANDS, weights)
        command(programmer)
        acts += [Act(moment + later, actor, kind, v) for later, kind, v in programmer.calls]
    return acts
