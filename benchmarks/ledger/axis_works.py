"""Works of axes: NC cycles, cams, planning, paths, drives, the bus, the camshaft, the scope."""

import random
from collections.abc import Callable
from math import cos, pi, sin
from typing import Any

Call = Callable[[], object]
CYCLE_NS = 2_000_000
MS = 1_000_000


def _ready(count: int, compiled: bool) -> Any:
    """Return an NC whose axes are enabled."""
    from achse.motion import AxisParameters, Nc

    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(
        CYCLE_NS,
        [AxisParameters(number, values=presets) for number in range(1, count + 1)],
        compiled=compiled,
    )
    nc.cycle()
    return nc


def _moving(nc: Any) -> Call:
    """Start moves of hours; return the cycle once velocities are steady."""
    from achse.motion import commands

    for axis in nc:
        commands.start(axis, 1, 1e7, 100.0)  # a slave refuses
    for _ in range(2000 if nc.compiled else 500):
        nc.cycle()
    cycle: Call = nc.cycle
    return cycle


def one_axis_plain() -> Call:
    """Set up an axis in plain Python."""
    return _moving(_ready(1, False))


def four_axes_plain() -> Call:
    """Set up 4 axes in plain Python."""
    return _moving(_ready(4, False))


def one_axis() -> Call:
    """Set up an axis in machine code."""
    return _moving(_ready(1, True))


def four_axes() -> Call:
    """Set up 4 axes in machine code."""
    return _moving(_ready(4, True))


def many_axes() -> Call:
    """Set up 255 axes in machine code."""
    return _moving(_ready(255, True))


def cam() -> Call:
    """Set up 255 axes, 128 of which follow 64 masters by a spline through 1,000 rows."""
    from achse.codes.nc.choices import TableSubType, TableType
    from achse.motion import commands
    from achse.motion.states import CamInterpolation, SlaveType
    from achse.motion.tables import TableParameters

    nc = _ready(255, True)
    rows = [(360.0 * n / 999, 10.0 * sin(2.0 * pi * n / 999)) for n in range(1000)]
    nc.tables.add_configured(
        TableParameters(1, rows, "", TableSubType.EQUIDISTANT_CYCLIC, TableType.CAMMING)
    )
    demand = commands.CamDemand(1, CamInterpolation.SPLINE, master_absolute=1)
    for slave in range(65, 193):
        master = (slave - 1) % 64 + 1
        code = commands.couple_by_cam(nc.axis(slave), SlaveType.TABULAR, master, demand)
        assert code == 0, f"axis {slave}: 0x{code:X}"
    return _moving(nc)


def planned_moves() -> Call:
    """Set up moves from drawn states."""
    from achse.motion.profiles.profile import plan_to_position
    from achse.motion.profiles.segments import MAX_SEGMENTS

    draw = random.Random(1)
    cases = [
        (
            *(0.0, draw.uniform(-80.0, 80.0), draw.uniform(-300.0, 300.0)),
            *(draw.uniform(-1000.0, 1000.0), 0.0, 100.0, 500.0, 400.0, 5000.0),
        )
        for _ in range(20)
    ]
    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS

    def plan() -> None:
        for case in cases:
            plan_to_position(times, jerks, *case)

    return plan


def path() -> Call:
    """Set up a path of short lines on a circle in space."""
    from achse.motion.path import PathLimits, PathParameters, PathPlanner, ReductionMethod

    limits = PathLimits(500.0, 10_000.0, 5e6)
    parameters = PathParameters(
        method=ReductionMethod.COSINE, c0=0.1, angle_low=5.0, angle_high=90.0
    )
    planner = PathPlanner(
        [limits] * 3, (0.0, 0.0, 0.0), cycle_time=0.001, parameters=parameters, compiled=True
    )
    radius, length = 20.0, 0.005
    block = 0

    def drive() -> None:
        nonlocal block
        free = planner.free
        angles = [length * (block + n + 1) / radius for n in range(free)]
        lines = [(radius * sin(a), radius * (1.0 - cos(a)), 0.0) for a in angles]
        block += planner.append_lines(lines, 100.0, block)
        planner.advance()

    for _ in range(300):
        drive()
    return drive


def drive() -> Call:
    """Set up a drive in Op that moves in csp."""
    import struct

    from achse.codes import AlState, AlStatus
    from achse.drive import Drive

    outputs = struct.Struct("<HbHiHI")  # 1600h
    drive = Drive(compiled=True)
    for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP):
        drive.enter(state, 0, AlStatus.NO_ERROR)
    for word in (0x00, 0x06, 0x07, 0x0F, 0x0F):
        drive.write_outputs(outputs.pack(word, 8, 3000, 0, 0, 0))
        drive.step(MS)
    position = int(drive.record.position_demand)

    def step() -> None:
        nonlocal position
        position += 200
        drive.write_outputs(outputs.pack(0x0F, 8, 3000, position, 0, 0))
        drive.step(MS)
        drive.read_inputs()

    return step


def cyclic_frame() -> Call:
    """Set up our master and a segment of 4 drives."""
    from achse.codes import AlState
    from achse.drive import Drive
    from achse.ethercat import Segment, Slave, describe
    from achse.ethercat.master import BusConfiguration, Master, Ring, from_description

    slaves = tuple(from_description(describe(Drive()), f"Drive {n + 1}") for n in range(4))
    master = Master(BusConfiguration(slaves, cycle_ns=MS))
    ring = Ring(master, Segment(Slave(Drive()) for _ in range(4)), rounds=50)
    master.request(AlState.OP)
    while not master.operational:
        ring.exchange(master.now_ns + MS)
    return lambda: ring.exchange(master.now_ns + MS)


def camshaft() -> Call:
    """Set up a controller of 128 cams of all kinds."""
    from achse.camshaft import CAMS, CamController, CamEncoder

    controller = CamController(encoder=CamEncoder(4096.0), compiled=True)
    for number in range(1, CAMS + 1):
        cam = {
            "type": 1 + number % 4, "start": number, "end": number + 90, "track": number % 32,
            "dynamic": 1, "dead_time": 100, "hysteresis_on": 1, "hysteresis": 10,
        }  # fmt: skip
        controller.set_cam(number, cam)
    position = 0.0

    def cycle() -> None:
        nonlocal position
        position = (position + 41.0) % 4096.0
        controller.take_position(position)
        controller.cycle()

    for _ in range(500):
        cycle()
    return cycle


def scope() -> Call:
    """Set up a recording of 64 LREALs in memory."""
    from achse.native.memory import MemoryCell
    from achse.scope import SCOPE_TYPES, Recorder, ScopeChannel, ScopeSource, definition_of

    memory = bytearray(8 * 64)

    def bind(channel: ScopeChannel) -> ScopeSource:
        return ScopeSource(
            MemoryCell(memory, 8 * int(channel.symbol), 8), SCOPE_TYPES["REAL64"], MS
        )

    definition = {
        "channels": [{"name": f"c{n}", "symbol": str(n)} for n in range(64)],
        "triggers": [f"c{n} rising 1" for n in range(64)],
        "record_length": 1.0,
    }
    recorder = Recorder(definition_of(definition), bind, compiled=True)
    recorder.start(0)
    now = 0

    def sample() -> None:
        nonlocal now
        now += MS
        if recorder.due_ns <= now:
            recorder.sample(now)

    for _ in range(1100):
        sample()
    return sample


def page_picture() -> Call:
    """Set up rows of a scope, some LREAL and some INT, as a page of the browser gets them."""
    import struct

    from achse.scope import SCOPE_TYPES
    from achse.web.sampling import SampleRows, columns_of

    types = [SCOPE_TYPES["REAL64" if n % 4 else "INT16"] for n in range(32)]
    words = [struct.pack("<d", n / 7) if n % 4 else struct.pack("<q", n) for n in range(32)]
    rows = SampleRows(MS, 40, b"".join(words) * 40, False)
    return lambda: columns_of(rows, MS, 0, types)
