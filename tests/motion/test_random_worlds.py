"""Drawn motion on a bare NC in virtual time, against the invariants of the swarm.

No station, clients or sockets: a few thousand worlds a minute. `--deep` plays more of them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

from achse.ams import DeviceError
from achse.client.nc.services import services
from achse.devices.nc.device import NcDevice
from achse.motion import AxisParameters, Nc
from achse.motion.states import TableType
from achse.motion.tables import TableParameters
from achse.swarm.clients import encode_service
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.watch import MotionWatch
from achse.swarm.worlds.couplings import draw_rare_motion
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.operators import draw_motion

FIRST = 4000
MS = 1_000_000
LENGTH_MS = 2500


@dataclass
class BareStation:
    """What the watch over axes looks at: an NC and a clock."""

    nc: Nc
    time_ns: int = 0
    faults: tuple[()] = ()


def play(seed: int) -> tuple[list[tuple[str, str]], int, bytes]:
    """What did not hold, the moves that axes took, and the digest at the end."""
    world, draws = draw_world(seed), Stream(seed, "bare world")
    axes = [
        AxisParameters(
            n,
            part.name,
            part.unit,
            {**part.values, "allow_slave_motion_commands": draws.randrange(2)},
        )
        for n, part in enumerate(world.axes, 1)
    ]
    tables = [
        TableParameters(n, [(x, y) for x, y in points], main_type=TableType.CAMMING)
        for n, points in enumerate(world.cams, 1)
    ]
    nc = Nc(world.cycle_ns, axes, tables=tables)
    device = NcDevice(nc, clock=int)
    acts = []
    for _ in range(12):
        moment = draws.randrange(LENGTH_MS) * MS
        acts += draw_motion(draws, moment, 0, world.axes, len(world.cams))
    if len(axes) > 1:
        moments = [draws.randrange(LENGTH_MS) * MS for _ in range(3)]
        acts += draw_rare_motion(draws, world.axes, 1, moments)
    broken: list[tuple[str, str]] = []
    bare = BareStation(nc)
    watch = MotionWatch(cast(Any, bare), world.axes, NAMES, lambda *what: broken.append(what))
    for act in sorted(acts, key=lambda act: act.at_ns):
        while bare.time_ns < min(act.at_ns, LENGTH_MS * MS) and not broken:
            bare.time_ns += nc.cycle_ns
            nc.cycle()
            watch.step(bare.time_ns)
        watch.wake()
        request(device, *act.values)
    return broken, watch.moves, nc.digest()


def request(device: NcDevice, group: int, name: str, axis: int, numbers: list[float]) -> None:
    """Request a service of an axis; it may refuse."""
    service = services()[group][name]
    data = encode_service(group, name, numbers)
    try:
        if service.answer is not None and not service.writable:
            device.read_write(*service.place(axis), service.answer.size, data)
        else:
            device.write(*service.place(axis), data)
    except DeviceError:
        pass


def test_drawn_motion_keeps_the_invariants(many: Callable[[int], int]) -> None:
    moves = 0
    for seed in range(FIRST, FIRST + many(12)):
        broken, done, _ = play(seed)
        assert not broken, (seed, broken[0])
        moves += done
    assert moves > 30


def test_equal_seeds_have_equal_digests() -> None:
    assert play(FIRST) == play(FIRST)
