"""Gates ahead: places where the bounds change, with what they allow.

A span of a bend allows less acceleration and jerk the faster it is followed. From a gate's *safe*
velocity, with no acceleration, all gates behind it can be kept span by span; the last one is at
rest. Each span is braked with what it allows at the velocity with which it is entered.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence

from achse.motion.path.bounds import ENDLESS, span_feed
from achse.motion.path.ramp import reachable
from achse.motion.path.record import PathGate, PathPiece, PathState, PieceKind

__all__ = [
    "build_gates",
    "gate_acceleration",
    "gate_deceleration",
    "gate_jerk",
    "piece_velocity",
]

_ROUNDS = 8
"""Halvings of the velocities of a bend, to find the one from which it can be braked."""


def piece_velocity(piece: PathPiece, k: int, state: PathState) -> float:
    """Velocity that a part of the piece shall have: programmed, reduced, with the override."""
    factor = min(state.override, state.most_override)
    if state.override_type == 1:  # original: the programmed velocity is meant
        return min(factor * span_feed(piece, k), piece.caps[k])
    return min(factor * min(span_feed(piece, k), piece.caps[k]), piece.caps[k])


def gate_acceleration(gate: PathGate, v: float) -> float:
    """Return the acceleration that the span before the gate permits up to velocity v, mm/s²."""
    share = min(v / gate.cap, 1.0)
    least = gate.start - (gate.start - gate.acceleration) * share * share
    return min(least, gate.most_acceleration)


def gate_deceleration(gate: PathGate, v: float) -> float:
    """Deceleration there at velocities up to v, mm/s²."""
    share = min(v / gate.cap, 1.0)
    least = gate.rest - (gate.rest - gate.deceleration) * share * share
    if least * v > gate.power:
        least = gate.power / v
    return min(least, gate.most_deceleration)


def gate_jerk(gate: PathGate, v: float) -> float:
    """Jerk there at velocities up to v, mm/s³."""
    share = min(v / gate.cap, 1.0)
    least = gate.first_jerk - (gate.first_jerk - gate.jerk) * share * share * share
    return min(least, gate.most_jerk)


def build_gates(pieces: Sequence[PathPiece], gates: Sequence[PathGate], state: PathState) -> None:
    """The gates ahead, in the direction of travel."""
    rows = len(pieces)
    x = -state.way if state.backwards else state.way
    count = 0
    n = state.current
    step = -1 if state.backwards else 1
    end = state.oldest - 1 if state.backwards else state.following
    last = False
    while n != end and not last:
        piece = pieces[n % rows]
        if state.backwards:
            last = n + step == end
            allowed = 0.0 if last else pieces[(n - 1) % rows].gate
        else:
            last = n + step == end or n == state.barrier
            allowed = 0.0 if piece.stops or last else piece.gate
        for m in range(piece.spans):
            k = piece.spans - 1 - m if state.backwards else m
            begin = piece.ends[k - 1] if k else 0.0
            if begin >= piece.length and k:
                continue  # lost to a curve
            gate = gates[count]
            final = m == piece.spans - 1
            if state.backwards:
                gate.at = -piece.first - begin
            else:
                final = final or piece.ends[k] >= piece.length
                gate.at = piece.first + (piece.length if final else piece.ends[k])
            if not final and gate.at <= x:
                continue  # behind already
            gate.ends = 1 if final else 0
            _fill(gate, piece, k, state)
            gate.limit = allowed if final else ENDLESS
            count += 1
            if final:
                break
        n += step
    state.gates = count
    state.gate = 0
    state.fresh = 1
    state.slower = 0
    if count:
        _make_safe(gates, state)


def _fill(gate: PathGate, piece: PathPiece, k: int, state: PathState) -> None:
    """Fill the gate with the limits of the span before it."""
    gate.waits = 1 if piece.kind == PieceKind.WAIT else 0
    gate.velocity = piece_velocity(piece, k, state)
    gate.cap = piece.caps[k]
    if gate.waits:
        gate.cap = gate.velocity = ENDLESS
    gate.start = piece.starts[k]
    gate.acceleration = piece.accelerations[k]
    gate.rest = piece.rests[k]
    gate.deceleration = piece.decelerations[k]
    gate.power = piece.powers[k]
    gate.first_jerk = piece.first_jerks[k]
    gate.jerk = piece.jerks[k]
    gate.most_acceleration = piece.path_acceleration
    gate.most_deceleration = piece.path_deceleration
    gate.most_jerk = piece.path_jerk
    if state.stop_deceleration > 0.0:
        gate.most_deceleration = max(gate.most_deceleration, state.stop_deceleration)
        gate.most_jerk = max(gate.most_jerk, state.stop_jerk)


def _make_safe(gates: Sequence[PathGate], state: PathState) -> None:
    """Limits and safe velocities, from the last gate back."""
    factor = min(state.override, 1.0)
    if state.override_type == 1:
        factor = 1.0
    end = gates[state.gates - 1]
    end.limit = end.safe = end.wanted_limit = end.wanted_safe = 0.0
    if end.velocity < end.cap:
        state.slower = 1
    for k in range(state.gates - 2, -1, -1):
        gate = gates[k]
        after = gates[k + 1]
        gate.wanted_limit = min(factor * gate.limit, after.velocity)
        gate.limit = min(gate.limit, after.cap)
        if gate.waits or after.waits:
            gate.limit = gate.wanted_limit = 0.0
        gate.safe = _entry(after, after.at - gate.at, after.safe, gate.limit)
        gate.wanted_safe = gate.safe
        if gate.wanted_limit < gate.limit or after.wanted_safe < after.safe:
            state.slower = 1
            most = min(gate.wanted_limit, gate.safe)
            gate.wanted_safe = _entry(after, after.at - gate.at, after.wanted_safe, most)


def _entry(gate: PathGate, length: float, speed: float, limit: float) -> float:
    """The highest velocity, up to a limit, from which the span before a gate leads to a speed.

    The places that are tried are always the same: where more is known, it falls only if a ramp to
    rest is shorter than one to the speed.
    """
    if limit <= speed:
        return limit
    down, jerk = gate_deceleration(gate, gate.cap), gate_jerk(gate, gate.cap)
    found = reachable(speed, length, down, jerk)
    even = gate.deceleration >= gate.rest and gate.jerk >= gate.first_jerk and gate.power >= ENDLESS
    if even or found >= limit:
        return min(found, limit)
    # the slower it is entered, the more it can brake
    low, high = 0.0, gate.cap
    for _ in range(_ROUNDS):
        v = 0.5 * (low + high)
        if v <= found:
            low = v
            continue
        entry = reachable(speed, length, gate_deceleration(gate, v), gate_jerk(gate, v))
        if entry >= v:
            low = v
            if low >= limit:
                return limit
        else:
            high = v
            found = entry
    return min(max(low, found), limit)
