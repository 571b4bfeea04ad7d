"""Chains of plans of a seed: all are played, and the first move that is wrong is described."""

from collections.abc import Callable
from functools import partial
from typing import Any

from achse.motion import AxisParameters, Nc
from achse.native.declare import pack
from achse.native.memory import Rows, structure_of
from achse.swarm.outcome import BrokenInvariant, WorldOutcome
from achse.swarm.plans.check import VERDICTS
from achse.swarm.plans.kernel import CHAINS, RUN, RunRows

CHAINS_OF_A_SEED = 20_000
"""Axes of a seed; some million of its moves take a second of machine code."""

MOVES_OF_A_CHAIN = 50
"""Commands that an axis gets, one in the motion of the other."""

_CYCLE_NS = 2_000_000
_COMPARED_EVERY = 64
_COMPARED_CHAINS = 20
_HALF = 32


class PlanPlayer:
    """An axis that plans, as plain Python or as machine code."""

    def __init__(self, *, compiled: bool | None = None) -> None:
        self.nc = Nc(_CYCLE_NS, [AxisParameters(1, "A1")], compiled=compiled)
        self._run: Callable[..., int]
        self.record: Any
        if self.nc.compiled:
            self._memory = Rows(RUN, 1)
            self.record = structure_of(RUN).from_buffer(self._memory.row(0))
            self._run = CHAINS.bind(
                *self.nc.kernel_arguments, self._memory.address, self._memory.count
            )
        else:
            self.record = RUN.plain()
            self._run = partial(CHAINS.plain, *self.nc.kernel_arguments, RunRows([self.record]))

    def play(self, seed: int, first: int, count: int, moves: int) -> BrokenInvariant | None:
        """Play chains of a seed; return the invariant that the first wrong move breaks."""
        low, high = seed & (1 << _HALF) - 1, seed >> _HALF
        verdict = self._run(low, high, first, count, moves)
        if not verdict:
            return None
        return BrokenInvariant(VERDICTS[verdict], self._describe())

    def digest(self) -> str:
        """Return the state of the axis and of the run as text."""
        return self.nc.digest().hex() + pack(RUN, self.record).hex()[:64]

    def _describe(self) -> str:
        """Return the plan of the move at work, for people."""
        axis, record, plan = self.nc.axis(1), self.record, self.record.plan
        profile = axis.profile
        segments = ", ".join(
            f"{profile.time[n]} s of {profile.jerk[n]}" for n in range(max(profile.count, 0))
        )
        return (
            f"chain {record.chain}, move {record.move}: from {plan.p0}, {plan.v0}, {plan.a0}"
            f" to {axis.target_position}; velocity {plan.highest}, acceleration {plan.rise},"
            f" deceleration {plan.fall}, jerk {plan.own_jerk}, override {axis.velocity_override};"
            f" segments {segments}"
        )


def play_chain(
    seed: int, chain: int, moves: int = MOVES_OF_A_CHAIN, *, compiled: bool | None = None
) -> BrokenInvariant | None:
    """Play one chain of a seed; return what its first wrong move breaks."""
    return PlanPlayer(compiled=compiled).play(seed, chain, 1, moves)


def play_plans(seed: int, *, compiled: bool | None = None) -> WorldOutcome:
    """Play all chains of a seed, some seeds in both kernels too; machine code if it may be used.

    Plain Python, a hundred times slower, plays a hundredth of them.
    """
    outcome = WorldOutcome()
    player = PlanPlayer(compiled=CHAINS.available if compiled is None else compiled)
    chains = CHAINS_OF_A_SEED if player.nc.compiled else CHAINS_OF_A_SEED // 100
    if player.nc.compiled and seed % _COMPARED_EVERY == 0:
        outcome.violation = _compare(seed)
    outcome.violation = outcome.violation or player.play(seed, 0, chains, MOVES_OF_A_CHAIN)
    outcome.moves = player.record.moves
    outcome.digest = player.digest()
    return outcome


def _compare(seed: int) -> BrokenInvariant | None:
    """Play some chains in both kernels."""
    digests = []
    for compiled in (True, False):
        player = PlanPlayer(compiled=compiled)
        player.play(seed, 0, _COMPARED_CHAINS, MOVES_OF_A_CHAIN)
        digests.append(player.digest())
    if digests[0] == digests[1]:
        return None
    return BrokenInvariant("equal-digest", f"{digests[0]} compiled, {digests[1]} plain")
