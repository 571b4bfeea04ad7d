"""Part programs run: they end where they must, wait where they must, stop when told to."""

import random
from itertools import pairwise
from math import cos, dist, hypot, inf, sin
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands
from achse.motion.channels.states import InterpreterState as State
from achse.motion.channels.states import ProgramMode


def test_a_program_ends_where_it_must(program: Any) -> None:
    """Line and end; the states on the way; it may run again."""
    assert program.run("N10 G01 X10 F600\nN20 M30\n") == 0
    seen = {program.channel.state}
    for _ in range(2000):
        program.cycle()
        seen.add(program.channel.state)
        if program.channel.state is State.READY:
            break
    assert program.at() == [10.0, 0.0, 0.0]
    assert seen >= {State.STARTED, State.END, State.READY}
    assert not any(axis.set_motion_phase for axis in program.nc)
    assert program.channel.start() == 0
    program.finish()


def test_arcs_stay_on_their_circle(program: Any) -> None:
    program.run("G01 X10 F6000\nG03 X10 Y20 I0 J10\nG02 X10 Y0 I0 J-10\nM30\n")
    far = 0.0
    while program.channel.state is not State.READY:
        program.cycle()
        x, y, _ = program.at()
        if x > 10.0:
            far = max(far, abs(hypot(x - 10.0, y - 10.0) - 10.0))
    assert program.at() == [10.0, 0.0, 0.0]
    assert far < 1e-5


def test_r_parameters_subroutines_and_loops(program: Any) -> None:
    program.channel.data.registers[1] = 2.5
    program.run(
        "R2=R1*2\nG01 X=R2 F6000\nL10 P3\nN50 @123 R3 K3 K60\nM30\nN60 Z1\nM30\nL10\nR3=R3+1\nG91\n"
        "Y1\nG90\nM17\n"
    )
    program.finish()
    assert program.at()[:2] == [5.0, 3.0]
    assert program.channel.data.registers[3] == 3.0


def test_an_m_function_with_handshake_waits_for_the_plc(program: Any) -> None:
    """The next block moves only after the PLC has granted; the level goes back to 0 between."""
    program.run("N10 G01 X5 F6000\nN20 M40\nN30 X10\nN40 M41\nN50 M30\n")
    out = program.channel.outputs
    program.until(lambda: out.request)
    assert (out.number, program.at()[0]) == (40, 5.0)
    assert program.channel.state is State.WAITING
    program.cycle(200)
    assert program.at()[0] == 5.0
    program.channel.granted = 1
    program.until(lambda: program.at()[0] == 10.0)
    program.cycle(100)
    assert (out.request, program.channel.state) == (0, State.WAITING)
    program.channel.granted = 0
    program.until(lambda: out.request)
    assert out.number == 41
    program.channel.granted = 1
    program.finish()


def test_fast_m_functions_and_words_follow_the_path(program: Any) -> None:
    program.run(
        "N10 G01 X5 F3000 M7 S800 T3\nN20 X10 H-5\nN30 X15 M8\nN40 X20 M9\nN50 X25\nN60 M2\n"
    )
    out = program.channel.outputs
    program.until(lambda: out.is_fast(7))
    assert program.at()[0] < 5.0
    assert (out.spindle, out.tool) == (800, 3)
    assert out.auxiliary == 0
    program.until(lambda: out.auxiliary == -5)
    assert 4.0 < program.at()[0] < 10.0
    program.until(lambda: not out.is_fast(7))
    assert 14.0 < program.at()[0] < 21.0
    program.finish()
    assert out.spindle == 800
    program.run("M7\nM30\n")
    program.finish()
    assert not any(out.fast)
    assert out.spindle == 0


def test_a_dwell_takes_its_time(program: Any) -> None:
    program.run("G01 X1 F6000\nG04 X0.5\nX2\nM30\n")
    program.until(lambda: program.at()[0] == 1.0)
    assert 240 <= program.until(lambda: program.at()[0] > 1.0) <= 260
    program.finish()


@pytest.mark.parametrize(
    ("text", "code", "index"),
    [
        ("N10 G01 X10 F6000\nN20 G99 X1\nM30\n", NcError.PROGRAM_SYNTAX_RUNNING, 18),
        ("N10 G01 X10\nM30\n", NcError.NCI_VELOCITY_NOT_POSITIVE, 0),
        ("G01 Q1=5 F100\nM30\n", NcError.NCI_AXIS_TYPE, 0),
        ("N10 L77\nM30\n", NcError.SUBROUTINE_MISSING, 0),
    ],
)
def test_a_wrong_block_aborts_and_keeps_its_place(
    program: Any, text: str, code: NcError, index: int
) -> None:
    program.run(text)
    program.until_state(State.ABORTED)
    assert program.channel.error_code in (code, NcError.G_FUNCTION_INDEX)
    assert program.channel.text_index == index
    assert program.channel.line_at(index) == text.split("\n")[1 if index else 0]
    assert program.channel.start() == NcError.NCI_RESET_NEEDED
    program.channel.reset()
    program.cycle(2)
    assert program.channel.state is State.IDLE
    assert program.channel.error_code == 0


def test_a_stop_brakes_on_the_path_and_wants_a_reset(program: Any) -> None:
    program.run("G01 X100 Y50 F12000\nM30\n")
    program.cycle(150)
    assert program.channel.stop() == 0
    assert program.channel.state is State.STOPPING
    while program.channel.state is State.STOPPING:
        program.cycle()
        x, y, _ = program.at()
        assert abs(y - 0.5 * x) < 1e-5
    assert program.channel.state is State.IDLE
    assert 0.0 < program.at()[0] < 100.0
    assert program.channel.start() == NcError.NCI_RESET_NEEDED
    program.channel.reset()
    assert program.channel.load("part.nc") == 0
    assert program.channel.start() == 0
    program.finish()
    assert program.at() == [100.0, 50.0, 0.0]


def test_an_emergency_stop_goes_on(program: Any) -> None:
    program.run("G01 X50 F6000\nM30\n")
    program.cycle(100)
    assert program.group.emergency_stop(5000.0, 100_000.0) == 0
    program.until(lambda: program.group.stands)
    assert program.group.emergency_stop_active == 1
    rest = program.at()[0]
    program.cycle(100)
    assert program.at()[0] == rest < 50.0
    assert program.group.step_on() == 0
    program.finish()
    assert program.at()[0] == 50.0


@pytest.mark.parametrize("mode", [ProgramMode.SINGLE_BLOCK, 0x4000])
def test_single_blocks(program: Any, mode: int) -> None:
    assert program.channel.set_operation_mode(mode) == 0
    program.run("G01 X1 F6000\nX2\nX3\nM30\n")
    rests = []
    for _ in range(6):
        program.until(lambda: program.channel.state in (State.SINGLE_STOP, State.READY))
        if program.channel.state is State.READY:
            break
        program.until(lambda: program.group.stands)
        program.cycle(50)
        rests.append(program.at()[0])
        assert program.channel.start() == 0
        program.cycle(2)
    assert program.channel.state is State.READY
    assert rests[:2] == [1.0, 2.0]
    assert program.at()[0] == 3.0
    assert program.channel.set_operation_mode(0x1000) == NcError.CHANNEL_START_PARAMETER


def test_decoder_stops(program: Any) -> None:
    """@714 waits for the path, @717 for function 0x30; #get reads positions."""
    program.run("G01 X5 F6000\n@717\nX8\n#get PathAxesPos(R1;R2;R3)#\nX=R1+1\nM30\n")
    program.until(lambda: program.at()[0] == 5.0)
    program.cycle(100)
    assert program.at()[0] == 5.0
    assert program.channel.go_ahead() == 0
    program.finish()
    assert program.at()[0] == 9.0
    assert program.channel.go_ahead() == NcError.CHANNEL_NO_DECODER_STOP


def test_the_distance_to_go_is_deleted_where_the_program_allows_it(program: Any) -> None:
    program.run("G01 X50 F6000 DelDTG\nY10\nM30\n")
    program.cycle(60)
    assert program.channel.delete_distance_to_go() == 0
    program.finish()
    x, y, _ = program.at()
    assert x < 50.0
    assert y == 10.0
    program.run("G01 X80 F6000\nM30\n")
    program.cycle(60)
    assert program.channel.delete_distance_to_go() == NcError.DELETE_DISTANCE_TO_GO


def test_homing_from_a_program(program: Any) -> None:
    for axis in program.nc:
        axis.homing_velocity_towards_cam = axis.homing_velocity_off_cam = 50.0
    program.run("G74 X\nG01 X3 F6000\nM30\n")
    program.finish()
    assert program.nc.axis(1).homed == 1
    assert program.at()[0] == 3.0


def test_an_axis_that_faults_aborts_the_program(program: Any) -> None:
    program.run("G01 X100 Y100 F6000\nM30\n")
    program.cycle(100)
    commands.set_external_error(program.nc.axis(2), 0x4650)
    program.until_state(State.ABORTED)
    assert program.channel.error_code == 0x4650
    program.until(lambda: not any(axis.set_velocity for axis in program.nc))
    program.channel.reset()
    program.cycle(3)
    assert program.channel.state is State.IDLE
    assert not any(axis.error_code for axis in program.nc)


def test_a_target_beyond_a_soft_limit(make_program: Any) -> None:
    program = make_program(encoder_soft_limit_max=20.0, encoder_soft_limit_max_enable=1)
    program.run("N10 G01 X10 F6000\nN20 X30\nM30\n")
    program.until_state(State.ABORTED)
    assert program.channel.error_code == NcError.NCI_BLOCK_BEYOND_SOFT_LIMITS
    assert program.channel.text_index == 18
    assert program.at()[0] <= 10.0


def test_override_changes_the_pace_at_once(program: Any) -> None:
    program.run("G01 X100 F6000\nM30\n")
    program.until(lambda: program.nc.axis(1).set_velocity > 99.9)
    program.channel.override = 250_000
    program.until(lambda: abs(program.nc.axis(1).set_velocity - 25.0) < 0.1)
    program.channel.override = 0
    program.until(lambda: program.nc.axis(1).set_velocity == 0.0)
    program.cycle(200)
    program.channel.override = 1_000_000
    program.finish()


def test_loading_is_for_a_channel_at_rest(program: Any) -> None:
    assert program.channel.start() == NcError.CHANNEL_NOT_READY
    assert program.channel.load("none.nc") == NcError.PROGRAM_OPEN
    assert program.channel.load("x" * 101) == NcError.PROGRAM_NAME_TOO_LONG
    program.write("G01 X50 F600\nM30\n", "7.nc")
    assert program.channel.load_number(7) == 0
    assert program.channel.program_number == 7
    assert program.channel.start() == 0
    program.cycle(10)
    assert program.channel.load_number(7) == NcError.CHANNEL_COMMAND_NOT_NOW
    assert program.group.dissolve() == NcError.GROUP_BUSY


def test_a_block_search_begins_in_the_middle(program: Any) -> None:
    """0x18, start, the axes are brought there, 0x19."""
    program.write("N10 G01 X10 F6000\nN20 X20\nN30 X30\nN40 Y5\nM30\n")
    channel = program.channel
    channel.load("part.nc")
    assert channel.enable_search(1, 1, 30, 50.0) == 0
    assert channel.start() == 0
    program.until(lambda: channel.search_result is not None)
    assert channel.state is State.SEARCHING
    assert channel.search_result.position == (25.0, 0.0, 0.0)
    assert channel.search_result.remaining == 50.0
    assert channel.step_on_after_search() == NcError.START_NOT_ON_CONTOUR
    assert program.group.dissolve() == 0
    assert commands.start(program.nc.axis(1), 1, 25.0, 100.0) == 0
    program.until(lambda: program.at()[0] == 25.0 and not program.nc.axis(1).set_motion_phase)
    assert program.group.assign([1, 2, 3]) == 0
    assert channel.step_on_after_search() == 0
    program.finish()
    assert program.at() == [30.0, 5.0, 0.0]
    assert channel.enable_search(9, 0, 0, 0.0) == NcError.CHANNEL_START_PARAMETER


def test_an_endless_program_does_not_hold_the_nc(program: Any) -> None:
    program.run("N10 R1=R1+1\nN20 @100 K-10\nM30\n")
    program.cycle(50)
    assert program.channel.data.registers[1] > 100
    program.channel.stop()
    program.until_state(State.IDLE)


@pytest.mark.parametrize("seed", range(6))
def test_a_cycle_runs_few_lines_whatever_a_program_repeats(program: Any, seed: int) -> None:
    """Loops (`@151`, `@100`) without an end, with computations and M functions in them."""
    source = random.Random(f"loops {seed}")
    loop = source.choice(("@151 R1 K{n} K900", "@131 R1 K0 K900", "@161 R1 K-{n} K900"))
    inside = [
        source.choice(("R2=R2+1", "M7", "M9", "(nothing)", "", "L5 P9", "@124 R3 K9 K800", "H3"))
        for _ in range(source.choice((0, 1, 20, 150)))
    ]
    lines = [f"N100 {loop.format(n=source.randrange(1, 99))}", *inside, "N800 @100 K-100"]
    program.run("\n".join([*lines, "N900 M30", "L5", "M17"]))
    interpreter = program.channel.interpreter
    for _ in range(40):
        before = interpreter.steps
        program.cycle()
        assert interpreter.steps - before <= 200
    assert interpreter.steps > 100
    assert program.channel.state is not State.READY
    program.channel.stop()
    program.until_state(State.IDLE)


def test_a_loop_that_counts_ends_where_it_must(program: Any) -> None:
    """`@151` leaves R1 alone: the program counts, as in the vendor's examples."""
    program.run("N10 @151 R1 K5 K40\nN20 R1=R1+1\nN30 @100 K-10\nN40 G01 X=R1 F6000\nM30\n")
    program.finish()
    assert program.channel.data.registers[1] == program.at()[0] in (5.0, 6.0)


BLOCKS = (
    *("G01 X{a} Y{b} F{f}", "G00 X{a}", "G02 X10 Y10 I5 J0", "M40", "M7", "M9", "M8", "M30"),
    *("G04 X0.02", "@714", "@717", "G74 X", "G01 Z{a} DelDTG", "G91", "G90", "G60", "H3 S4 T5"),
    *("#set paramVertexSmoothing(2;1;0.5)#", "DYNOVR=0.5", "R1=R1+1", "G999", "X{b} Y{a} Z{b}"),
    *("#get PathAxesPos(R1;R2;R3)#", "G17 G03 X{a} Y{b} B50", "#set paramVertexSmoothing(5;3;1)#"),
)


@pytest.mark.parametrize("seed", range(4))
def test_whatever_happens_a_reset_brings_it_back(program: Any, seed: int) -> None:
    """Programs and commands at random: no jump, nothing hangs, afterwards a program runs."""
    source = random.Random(seed)
    channel, group = program.channel, program.group
    for axis in program.nc:
        axis.homing_velocity_towards_cam = axis.homing_velocity_off_cam = 100.0

    def numbers() -> dict[str, int]:
        pair = {"a": source.randint(-30, 30), "b": source.randint(-30, 30)}
        return pair | {"f": source.choice((600, 6000, 60_000))}

    def load_and_start() -> None:
        count = source.randrange(1, 12)
        program.write("\n".join(source.choice(BLOCKS).format(**numbers()) for _ in range(count)))
        channel.load("part.nc")
        channel.start()

    actions = (
        *(load_and_start, load_and_start, load_and_start, channel.stop, channel.reset),
        *(channel.go_ahead, channel.delete_distance_to_go, group.step_on, channel.start),
        *(group.dissolve, lambda: group.assign([1, 2, 3]), group.stop, group.reset),
        lambda: group.emergency_stop(source.choice((0.0, 1e4)), source.choice((0.0, 1e5))),
        lambda: setattr(channel, "granted", source.randrange(2)),
        lambda: setattr(channel, "override", source.choice((0, 300_000, 1_000_000))),
        lambda: channel.set_operation_mode(source.choice((0, 1, 0x4000))),
        lambda: channel.enable_search(source.randrange(3), source.randrange(4), 2, 50.0),
        lambda: commands.stop(program.nc.axis(1)),
        lambda: commands.set_external_error(program.nc.axis(2), 0x4650),
        lambda: setattr(program.nc.axis(3), "control_dword", source.choice((0, 7, 7, 7))),
    )
    for _ in range(60):
        source.choice(actions)()
        before = program.at()
        for _ in range(source.choice((1, 5, 50, 200))):
            program.cycle()
            now = program.at()
            homed = any(axis.homed for axis in program.nc)
            assert homed or all(abs(a - b) < 4.1 for a, b in zip(now, before, strict=True))
            before = now
    for axis in program.nc:
        axis.control_dword = 7
    channel.override = 1_000_000
    channel.stop()
    channel.reset()
    program.cycle(3000)
    channel.reset()
    program.cycle(5)
    for axis in program.nc:
        commands.reset(axis)
    program.cycle(5)
    assert channel.state is State.IDLE
    assert not group.moving
    assert not any(axis.set_velocity or axis.set_motion_phase for axis in program.nc)
    assert group.assign([1, 2, 3]) == channel.set_operation_mode(0) == 0
    channel.enable_search(0, 0, 0, 0.0)
    assert program.run("G90 G01 X1 F6000\nM30\n") == 0
    program.finish()
    assert program.at()[0] == 1.0


def _short_lines(count: int) -> list[tuple[float, float, float]]:
    """Points 5 µm apart on a bend."""
    points, x, y = [], 0.0, 0.0
    for n in range(count):
        x, y = x + 0.005 * cos(n / 150.0), y + 0.005 * sin(n / 150.0)
        points.append((round(x, 6), round(y, 6), round(n * 1e-4, 6)))
    return points


def _off(place: tuple[float, ...], points: list[tuple[float, float, float]]) -> float:
    """Distance from the lines between points."""
    least = inf
    for begin, end in pairwise([(0.0, 0.0, 0.0), *points]):
        way = [b - a for a, b in zip(begin, end, strict=True)]
        gone = [b - a for a, b in zip(begin, place, strict=True)]
        along = sum(a * b for a, b in zip(way, gone, strict=True)) / sum(a * a for a in way)
        along = min(max(along, 0.0), 1.0)
        least = min(least, dist(gone, [along * a for a in way]))
    return least


def test_short_lines_go_over_at_once_with_the_same_motion(make_program: Any) -> None:
    """60 blocks of 5 µm in a cycle: the contour is kept, as it is with one by one."""
    points = _short_lines(400)
    lines = [f"X{x:.6f} Y{y:.6f} Z{z:.6f}" for x, y, z in points]
    text = "\n".join(["G1 F10000", *lines, "M30"])
    ways: dict[int, list[tuple[float, ...]]] = {}
    for alone in (0, 1):
        rig = make_program(default_acceleration=100_000.0, default_deceleration=100_000.0)
        for axis in rig.nc:
            axis.max_acceleration = axis.max_deceleration = 100_000.0
            axis.default_jerk = 1e8
        rig.group.max_commands_per_cycle = 60
        rig.group.critical_angle_low = 10.0
        rig.channel.feeder_log_enable = alone  # a log has each line, so they go one by one
        assert rig.run(text) == 0
        way = ways.setdefault(alone, [])
        while rig.channel.state is not State.READY:
            rig.cycle()
            way.append(tuple(rig.nc.axis(n).set_position for n in (1, 2, 3)))
            assert len(way) < 1000, rig.channel.state
        assert rig.channel.error_code == 0
        assert dist(way[-1], points[-1]) < 1e-12
    assert ways[0] == ways[1]
    assert max(_off(place, points) for place in ways[0][::3]) < 1e-9


@pytest.mark.parametrize(
    ("line", "code"),
    [("X3 Y2", NcError.NCI_BLOCK_BEYOND_SOFT_LIMITS), ("Z1", NcError.NCI_AXIS_TYPE)],
)
def test_a_line_in_the_middle_that_cannot_be_is_the_one_reported(
    program: Any, line: str, code: int
) -> None:
    axis = program.nc.axis(2)
    axis.encoder.soft_limit_max_enable, axis.encoder.soft_limit_max = 1, 1.5
    if code == NcError.NCI_AXIS_TYPE:
        assert program.group.assign([1, 2, 0]) == 0
    program.group.max_commands_per_cycle = 20
    lines = ["G1 F600", *(f"X{n}" for n in range(1, 9)), line, "X9", "M30"]
    text = "\n".join(lines)
    assert program.run(text) == 0
    program.until_state(State.ABORTED)
    assert program.channel.error_code == code
    assert program.channel.text_index == text.index(line)


def test_short_lines_show_their_block_and_survive_a_full_table(program: Any) -> None:
    program.group.max_commands_per_cycle = 1000
    lines = [f"N{n} X{n * 0.1:.1f}" for n in range(1, 301)]
    assert program.run("\n".join(["G1 F6000", *lines, "M30"])) == 0
    program.group.critical_angle_low = 10.0
    seen, states = [], set()
    while program.channel.state is not State.READY:
        program.cycle()
        states.add(program.channel.state)
        if program.channel.feeder is not None:
            seen.append(program.channel.block_number)
    assert program.at() == [30.0, 0.0, 0.0]
    assert seen == sorted(seen)
    assert len(set(seen)) > 50
    assert State.TABLE_FULL in states


def test_retry_runs_the_block_at_fault_again(program: Any) -> None:
    """A feed was missing: once R1 has one, the program goes on where it stopped."""
    channel = program.channel
    assert channel.retry() == channel.skip() == NcError.CHANNEL_COMMAND_NOT_NOW
    text = "N10 G1 X10 F6000\nN15 @714\nN20 R2=R2+1\nN30 F=R1\nN40 Y5\nN50 X0\nM30"
    assert program.run(text) == 0
    program.until_state(State.ABORTED)
    assert (channel.error_code, program.at()) == (NcError.NCI_VELOCITY_NOT_POSITIVE, [10.0, 0, 0])
    channel.data.registers[1] = 1200.0
    assert channel.retry() == 0
    program.finish()
    assert program.at() == [0.0, 5.0, 0.0]
    assert [channel.data.registers[n] for n in (1, 2)] == [1200.0, 1.0]


def test_skip_leaves_out_the_block_at_fault(program: Any) -> None:
    """A block that nobody can read, and one that cannot be run; R parameters count once."""
    for wrong in ("N30 [X", "N30 G2 X20 Y0 B1", "N30 M200"):
        text = f"N10 G1 F6000\nR2=R2+1\n@714\n{wrong}\nN40 Y5\nN50 Y0\nM30"
        program.channel.data.registers[2] = 0.0
        assert program.run(text) == 0
        program.until_state(State.ABORTED)
        assert program.channel.text_index == text.index("N30")
        assert program.channel.retry() == 0
        program.until_state(State.ABORTED)
        assert program.channel.text_index == text.index("N30"), "it fails again"
        assert program.channel.skip() == 0
        program.finish()
        assert program.at() == [0.0, 0.0, 0.0]
        assert program.channel.data.registers[2] == 1.0
        program.channel.reset()
        program.cycle(3)


def test_after_a_fault_of_an_axis_the_axes_are_brought_to_the_block(program: Any) -> None:
    channel, axis = program.channel, program.nc.axis(1)
    assert program.run("N10 G1 X50 F6000\nN20 X100\nN30 Y9\nM30") == 0
    program.until(lambda: program.at()[0] > 60.0)
    commands.set_external_error(axis, 0x4650)
    program.until_state(State.ABORTED)
    assert channel.retry() != 0, "the axis has its error still"
    assert program.group.reset() == 0
    program.until(lambda: channel.retry() == 0, 5.0)
    program.until(lambda: channel.search_result is not None)
    program.cycle(3)
    assert channel.state is State.SEARCHING
    assert channel.search_result.position == (50.0, 0.0, 0.0)
    assert program.group.dissolve() == 0
    assert commands.start(axis, 1, 50.0, 100.0) == 0
    program.until(lambda: program.at()[0] == 50.0 and not axis.set_motion_phase)
    assert program.group.assign([1, 2, 3]) == 0
    assert channel.step_on_after_search() == 0
    program.finish()
    assert program.at() == [100.0, 9.0, 0.0]


@pytest.mark.parametrize("word", ["D=R1 X1", "H=R1", "T=R1", "L7 PR1", "@100 R1", "ROT XR1"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_what_is_not_a_number_ends_the_program_only(program: Any, word: str, value: float) -> None:
    program.channel.data.registers[1] = value
    program.run(f"N10 {word}\nM30\nL7\nM17")
    program.until_state(State.ABORTED)
    assert program.channel.error_code == NcError.FLOATING_POINT_OPERATION
