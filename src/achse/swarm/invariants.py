"""The invariants: what holds in every world, each with its source and what looks after it.

Those of motion are checked for each axis and cycle (`achse.swarm.motion.checks`). The others are
looked after where the events are, and report by the name of their row.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Invariant:
    """One row: name, statement, source and exception."""

    name: str
    statement: str
    source: str
    excused: str = ""
    """Cases in which it is not checked, and why."""
    where: str = ""
    """Module of `achse.swarm` that looks after it, unless it is one of motion."""


_ABRUPT = (
    "reset in motion, new actual position, loop opened or closed, an external set point that moves:"
    " the manuals are abrupt there"
)
_SLAVES = "slaves of gears follow beyond their limits (decision 0186)"

INVARIANTS = (
    Invariant(
        "finite", "Set position, velocity and acceleration are numbers.", "design, idea 6",
    ),
    Invariant(
        "velocity", "No axis is faster than its maximum velocity, superposed motion included.",
        "002 §6.4.4.1, 0x4000+ID: 0x27; design, idea 6: a limit holds for the sum",
        f"{_ABRUPT}; {_SLAVES}, until they rest",
    ),
    Invariant(
        "acceleration", "No acceleration or deceleration beyond its maximum begins.",
        "002 §6.4.4.1; design, idea 6",
        f"{_ABRUPT}; {_SLAVES}; while a section compensation, a trapezoid, is active",
    ),
    Invariant(
        "jerk", "Acceleration changes by the jerk, velocity by the acceleration.",
        "002 §6.4.4.3, 0x4200+ID: 0x16",
        f"{_ABRUPT}; coupled axes; a section compensation, a trapezoid, and a stop for a soft limit"
        " behind one (decision 0218)",
    ),
    Invariant(
        "position", "An axis goes as far in a cycle as its velocity says.", "design, idea 6",
        f"{_ABRUPT}; slaves of cams, see slave-step, and slaves of those; the cycle of a new ratio;"
        " for slaves of gears the change of velocity in the cycle, and what the jerk of masters"
        " does within it",
    ),
    Invariant(
        "stop", "A stop takes acceleration away in the direction of motion, and adds none.",
        "004 §3.1.2; design, idea 6", f"{_ABRUPT}; coupled axes, a section compensation",
    ),
    Invariant(
        "rest", "An axis without a motion keeps its set point.", "004 §3.1.2",
        f"{_ABRUPT}; coupled axes; the cycle of a command",
    ),
    Invariant(
        "slave-step", "No slave of a cam goes farther in a cycle than velocity of axis and drive.",
        "decision 0124", _ABRUPT,
    ),
    Invariant(
        "gear-law",
        "A slave of a gear goes as far and as fast as its master, times the ratio, a new one too.",
        "004 §3.1.4; decision 0186", f"{_ABRUPT}; the first cycle; a section compensation",
    ),
    Invariant(
        "coupled-way",
        "A slave of a saw or cyclic gear goes by its velocity, that by its acceleration.",
        "decisions 0035, 0037",
        f"{_ABRUPT}; gears and cams, see gear-law and slave-step; the first cycle of a law and of"
        " its parameters (0037: a saw takes another gear at once); saws on a curve over their"
        " master, or that their mask stops at once; what a master does within a cycle;"
        " slaves of slaves that may jump",
    ),
    Invariant(
        "new-ratio", "A new ratio makes no slave faster than axis and drive may be.",
        "decisions 0037, 0186", f"{_ABRUPT}; a master that becomes faster later (0186)",
    ),
    Invariant(
        "known-codes", "An error of an axis has a code of the table.", "001, NC error codes",
        "worlds with a station around the motion", where="motion/player",
    ),
    Invariant(
        "cam-switching",
        "A track of the camshaft controller is on exactly within the angles of its cams.",
        "000 §5.5.2.3", "an angle at the edge of a cam, within rounding; way cams alone are drawn",
        where="services/cam_watch",
    ),
    Invariant(
        "scope-samples", "A scope has each sample of its channel once, in order, with its value.",
        "docs: record values with the scope", "", where="services/scope_watch",
    ),
    Invariant(
        "rights", "A request that rights forbid is refused, and changes nothing; others are not.",
        "docs: what a route may",
        "while a fault of frames is active; requests that no honest client sends",
        where="talk",
    ),
    Invariant(
        "drive-error",
        "An axis whose drive has an alarm or STO reports an error, or its loop is open.",
        "NC errors 0x4650 (drive not ready in motion), 0x4225",
        "the first 100 ms; a drive whose processor hangs, and says nothing",
        where="drive_watch",
    ),
    Invariant(
        "channel-states", "A channel changes its state by drawn transitions, commanded or its own.",
        "achse.motion.channels.states: TRANSITIONS", "cycles with a request, active faults",
        where="channel_watch",
    ),
    Invariant(
        "path-tolerance", "A path keeps to its contour, and to the radius of smoothing in corners.",
        "docs: life of a path; paramVertexSmoothing",
        "programs that begin by a block search; an axis that brakes by itself",
        where="channel_watch",
    ),
    Invariant(
        "answered-once", "Every request is answered once, to the connection that asked.",
        "000 §3.2; life of a request",
        "requests under way while a fault of frames is active; connections that ended",
        where="talk",
    ),
    Invariant(
        "no-broken-stream", "What a client receives is AMS/TCP, wherever it is cut.", "000 §3.2",
        "while a fault of frames is active", where="clients",
    ),
    Invariant(
        "samples-to-subscriber", "A sample comes to the connection that subscribed, to no other.",
        "000 §3.2.3.8", "handles whose answer a fault of frames may have hit", where="talk",
    ),
    Invariant(
        "samples-in-order", "The samples of a subscription come in order, each once.",
        "000 §3.2.3.8; decision 0120", "while a fault of notifications or links is active",
        where="talk",
    ),
    Invariant(
        "samples-complete", "A cyclic subscription has a sample each cycle, or it is counted lost.",
        "000 §3.2.3.6; decision 0120",
        "restart, online change, samples counted as dropped or late, faults as above; behind a"
        " router that has lost its target",
        where="talk",
    ),
    Invariant(
        "bounded", "Handles, subscriptions and queued bytes stay within the limits.",
        "decisions 0011, 0065", where="resources",
    ),
    Invariant(
        "released",
        "A minute after all clients have left neither station nor routers hold anything for them.",
        "decisions 0011, 0116, 0230",
        "abandoned handles, within their limit, of clients without a router; those of routers when"
        " a fault of frames may have hit a release",
        where="resources",
    ),
    Invariant(
        "restart-released", "What a restart replaced is released.", "decision 0009",
        where="resources",
    ),
    Invariant(
        "kept", "What was saved is there after a kill or a power failure in a write.",
        "decision 0118", where="play",
    ),
    Invariant(
        "no-traceback", "No exception leaves the cycle or is logged, and no PLC program fails.",
        "design, idea 4", where="play",
    ),
    Invariant(
        "equal-digest", "Equal worlds have equal digests, in both kernels.", "decision 0005",
        where="play",
    ),
    Invariant(
        "flat", "A world leaves no memory behind.", "decision 0011", where="resources",
    ),
)  # fmt: skip
"""All invariants, in the order of the docs."""


def invariant_rows() -> list[str]:
    """Return the table for the docs, in Markdown."""
    lines = ["| name | what holds | source | not checked |", "|---|---|---|---|"]
    lines += [
        f"| `{row.name}` | {row.statement} | {row.source} | {row.excused or '–'} |"
        for row in INVARIANTS
    ]
    return lines
