"""Every method of an axis in any order, each argument drawn: all end in a result or a typed error.

Meanwhile another client commands the same axis, its enables are taken away, errors come, the
connection is lost.
"""

from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from achse.ams import AdsError
from achse.client.nc import AxisStatus, Move, PlcOpenState
from achse.client.nc.conditions import CONDITIONS
from achse.client.nc.services import FUNCTIONS, PARAMETERS, services
from achse.codes.axis import BufferMode, StateBit
from achse.motion import commands

NUMBERS: st.SearchStrategy[Any] = st.one_of(
    st.floats(-500, 500),
    st.floats(),
    st.sampled_from([0.0, -0.0, 1e-300, 1e15, 1e300, 10**400, -1, 3]),
    st.sampled_from(["1", None, b"", []]),
)
SPEEDS = st.one_of(st.floats(20, 1000), NUMBERS)
DYNAMICS = st.one_of(st.just(0.0), st.floats(100, 20_000), NUMBERS)
LIMITS = st.one_of(st.floats(0, 2), st.sampled_from([-1.0, float("nan"), 0, "soon"]))
WAYS = {
    "velocity": SPEEDS,
    "acceleration": DYNAMICS,
    "deceleration": DYNAMICS,
    "jerk": DYNAMICS,
    "buffer": st.sampled_from([*BufferMode, "buffered", "blending next", "soon", 7]),
    "blending_position": st.one_of(st.just(0.0), NUMBERS),
    "start_velocity": st.one_of(st.just(0.0), NUMBERS),
    "end_velocity": st.one_of(st.just(0.0), NUMBERS),
    "wait": st.booleans(),
}
RAMP = {"deceleration": DYNAMICS, "jerk": DYNAMICS, "wait": st.booleans()}


def _call(name: str, *arguments: Any, **fields: Any) -> Any:
    """A call with its arguments; some of the fields are left out."""
    return st.tuples(
        st.just(name), st.tuples(*arguments), st.fixed_dictionaries({}, optional=fields)
    )


def _always(name: str, *arguments: Any, **fields: Any) -> Any:
    """The same with a time limit that is always there: a move may be meant to last for years."""
    return st.tuples(
        st.just(name),
        st.tuples(*arguments),
        st.fixed_dictionaries({"within": LIMITS}, optional=fields),
    )


CALLS = st.one_of(
    _always("enable", positive=st.booleans(), negative=st.booleans(), override=NUMBERS),
    _always("enable"),
    _always("disable"),
    _always("reset"),
    _always("move_to", NUMBERS, modulo=st.sampled_from(["shortest", "+", "-", None, "up"]), **WAYS),
    _always("move_to", st.floats(-100, 100), velocity=st.floats(50, 500)),
    _always("move_by", NUMBERS, **WAYS),
    _always("move_velocity", SPEEDS, buffer=WAYS["buffer"], acceleration=DYNAMICS, **RAMP),
    _always("halt", **RAMP),
    _always("stop", lock=st.booleans(), **RAMP),
    _call("release"),
    _always("home", wait=st.booleans()),
    _call(
        "jog",
        st.sampled_from(["+", "-", "up", 1]),
        speed=st.sampled_from(["slow", "fast", "rapid", "warp"]),
        duration=LIMITS,
    ),
    _call("set_position", NUMBERS, relative=st.booleans(), moving=st.booleans()),
    _call("set_homed", homed=st.booleans()),
    _call("set_override", NUMBERS),
    _call("override"),
    _call("status"),
    _call("error"),
    _always("wait_for", st.sampled_from([*CONDITIONS, *PlcOpenState, StateBit.HOMED, "soon", 3])),
    _call("call", st.sampled_from([*services()[FUNCTIONS], "fly"]), NUMBERS, NUMBERS),
    _call("call", st.sampled_from([*services()[FUNCTIONS]])),
    _call("parameters", st.sampled_from([*services()[PARAMETERS], "colour"]), NUMBERS),
    _call("finished"),
)

DISTURBANCES = st.one_of(
    st.none(),
    st.tuples(
        st.sampled_from(["command", "enables", "error", "loss", "stop", "override"]),
        st.floats(0, 3),
        st.floats(-200, 200),
    ),
)


class _Session:
    """One axis, what is drawn for it, and what it answered."""

    def __init__(self, bench: Any) -> None:
        self.bench = bench
        self.moves: list[Move] = []

    async def do(self, name: str, arguments: tuple[Any, ...], fields: dict[str, Any]) -> Any:
        axis = self.bench.axis
        if name == "parameters":
            value = axis.parameters[arguments[0]]
            await value.write(arguments[1])
            return await value
        if name == "finished":
            return await self.moves[-1].finished(within=1.0) if self.moves else None
        if name in ("move_to", "move_by") and "velocity" not in fields:
            fields = fields | {"velocity": 100.0}
        return await getattr(axis, name)(*arguments, **fields)

    def disturb(self, kind: str, moment: float, number: float) -> Callable[[float], None]:
        begin = self.bench.station.time_ns / 1e9
        record = self.bench.station.nc.axis(1)
        done = False

        def hook(time: float) -> None:
            nonlocal done
            if done or time < begin + moment:
                return
            done = True
            if kind == "command":
                commands.universal_start(record, 1, number, 100.0, 500.0, 500.0, 5000.0)
            elif kind == "stop":
                commands.stop(record)
            elif kind == "enables":
                record.control_dword = 0
            elif kind == "override":
                record.velocity_override = 0
            elif kind == "error":
                commands.set_external_error(record, 0x4655)
            elif self.bench.client.session.link is not None:
                self.bench.client.session.link.abort()

        return hook


@settings(
    max_examples=13,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(sequence=st.lists(st.tuples(CALLS, DISTURBANCES), min_size=1, max_size=12))
def test_every_call_ends(on_bench: Callable[..., Any], sequence: list[Any]) -> None:
    async def test(bench: Any) -> None:
        session = _Session(bench)
        for (name, arguments, fields), disturbance in sequence:
            bench.hooks[:] = [session.disturb(*disturbance)] if disturbance else []
            note(f"{name}{arguments}{fields}")
            try:
                result = await session.do(name, arguments, fields)
            except (AdsError, ValueError, LookupError):
                continue
            if isinstance(result, Move):
                session.moves.append(result)
                if fields.get("wait", name != "jog"):
                    assert isinstance(result.status, AxisStatus)

    on_bench(test)
