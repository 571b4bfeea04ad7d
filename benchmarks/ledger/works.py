"""The fixed works of the ledger: a name, what one repetition does, and its set-up.

A set-up is a function of a module of this folder. It imports what it needs itself, so that a work
whose parts are not in a tree leaves the others alone. It returns the work: a function without
arguments, each call of which does the same again.
"""

from typing import NamedTuple

__all__ = ["WORKS", "Work"]


class Work(NamedTuple):
    """One fixed work."""

    name: str
    what: str
    """What one repetition does."""
    set_up: str
    """Module and function."""
    repetitions: int = 0
    """Repetitions of the first run; a second run has twice as many, the difference counts. 0: a
    process of its own does the work once."""

    @property
    def place(self) -> str:
        """The work as an argument of `counted.py`."""
        return f"{self.set_up}:{self.repetitions}"


WORKS = (
    Work("read", "read 4 bytes by handle, from frame to frame", "request_works:read", 100),
    Work("read by name", "read 4 bytes by symbol name (0xF004)", "request_works:read_by_name", 50),
    Work("write", "write 4 bytes by handle", "request_works:write", 100),
    Work("sum read", "read 50 symbols by handle in one request", "request_works:sum_read", 5),
    Work("axis read", "read the position of an axis at port 501", "request_works:axis_read", 100),
    Work("frames", "64 read requests in one portion of a TCP stream", "request_works:frames", 2),
    Work("samples", "10 ms of the demo station with 100 subscriptions", "request_works:samples", 5),
    Work(
        "watched at rest",
        "100 ms of 4 axes at rest, a client watches 80 values",
        "request_works:watched_at_rest",
        20,
    ),
    Work("watched moving", "the same with axes that move", "request_works:watched_moving", 20),
    Work(
        "watched in turns",
        "the same with a phase in Python each 10 ms",
        "request_works:watched_in_turns",
        10,
    ),
    Work("symbol upload", "the symbol table of the demo PLC (0xF00B)", "request_works:upload", 100),
    Work("tick at rest", "10 ms of the demo station at rest", "request_works:tick_at_rest", 20),
    Work("tick moving", "10 ms of the demo station, 3 axes move", "request_works:tick_moving", 20),
    Work("1 axis plain", "NC cycle of an axis, plain Python", "axis_works:one_axis_plain", 20),
    Work("4 axes plain", "NC cycle of 4 axes, plain Python", "axis_works:four_axes_plain", 10),
    Work("1 axis", "NC cycle of an axis, machine code", "axis_works:one_axis", 200),
    Work("4 axes", "NC cycle of 4 axes, machine code", "axis_works:four_axes", 200),
    Work("255 axes", "NC cycle of 255 axes, machine code", "axis_works:many_axes", 20),
    Work("cam", "NC cycle of 255 axes, 128 of them by spline cams", "axis_works:cam", 20),
    Work("move", "plan 20 moves from any state, plain Python", "axis_works:planned_moves", 1),
    Work("path", "append 128 lines of 5 µm to a path and drive 1 ms", "axis_works:path", 5),
    Work("drive", "1 ms of a moving CiA 402 drive, machine code", "axis_works:drive", 20),
    Work("cyclic frame", "EtherCAT cycle with 4 drives in Op", "axis_works:cyclic_frame", 20),
    Work("camshaft", "cycle of a controller of 128 cams", "axis_works:camshaft", 20),
    Work("scope", "sample of 64 scope channels with triggers", "axis_works:scope", 50),
    Work("statement plain", "100 statements of Structured Text, plain", "plc_works:plain", 5),
    Work("statement", "1,000 statements, machine code", "plc_works:machine", 20),
    Work("counted plain", "100 statements with coverage, plain", "plc_works:plain_counted", 5),
    Work(
        "counted", "1,000 statements with coverage, machine code", "plc_works:machine_counted", 20
    ),
    Work("loops plain", "loops of tiny blocks, plain", "plc_works:plain_loops", 5),
    Work("loops counted plain", "the same with coverage", "plc_works:plain_loops_counted", 5),
    Work("loops", "10 loops of tiny blocks, machine code", "plc_works:loops", 20),
    Work("loops counted", "the same with coverage", "plc_works:loops_counted", 20),
    Work("block", "2 ms of 4 axes with 5 blocks of Tc2_MC2 each", "plc_works:blocks", 50),
    Work("part program", "interpret 100 blocks of G-code", "plc_works:part_program", 1),
    Work("check", "parse, declare and check 120 statements", "plc_works:check_sources", 1),
    Work(
        "page picture",
        "40 rows of 32 channels for a page",
        "axis_works:page_picture",
        5,
    ),
    Work("import", "import achse", "cold_works:import_achse"),
    Work("help", "print achse --help", "cold_works:show_help"),
    Work("check project", "achse check of a small project", "cold_works:check_project"),
    Work("ready", "import, build and open the demo station", "cold_works:ready"),
)
"""All works, in the order of the ledger."""
