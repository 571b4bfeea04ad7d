"""Sampling as a kernel: the values of all channels of a group into the next row of its ring.

The same function runs as plain Python on a table of words and as machine code on all memory. Values
of any size and place are words of 8 bytes in the ring; triggers compare whole numbers that have the
order of the values (`ScopeType.key`), so that no type needs a case of its own.
"""

from collections.abc import MutableSequence, Sequence

from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out
from achse.scope.trigger import TriggerEvent


class SampledChannel:
    """Place of a channel's value: word, first bit in the word, and the bits that count."""

    place: int = 0
    """The word with its first bit."""
    shift: int = 0
    """Position of the first bit in that word."""
    spills: int = 0
    """1 if the value continues in the next word, else 0."""
    mask: int = 0
    """The bits that count."""


class WatchedChannel:
    """A trigger: the band of keys, how keys are made, and what was in the sample before."""

    channel: int = 0
    """Index of the channel in the row."""
    sign: int = 0
    flip: int = 0
    turn: int = 0
    least: int = 0
    most: int = 0
    """Keys of values; NaN is outside."""
    low: int = 0
    high: int = 0
    inverted: int = 0
    event: int = 0
    state: int = -1
    """Result of the condition in the sample before: 0, 1, or -1 if unknown."""


SAMPLED = lay_out("SampledChannel", [SampledChannel], Slot)
WATCHED = lay_out("WatchedChannel", [WatchedChannel], Slot)


def take_sample(
    memory: Sequence[int],
    channels: Sequence[SampledChannel],
    ring: MutableSequence[int],
    triggers: Sequence[WatchedChannel],
    row: int,
) -> int:
    """Write a sample of each channel into row number `row`; how many triggers fire."""
    first = row * len(channels)
    for n in range(len(channels)):
        channel = channels[n]
        word = memory[channel.place]
        shift = channel.shift
        if shift:
            word = word >> shift
            if channel.spills:
                # the low bits of the next word, with its sign: no number leaves 64 bits
                half = 1 << (shift - 1)
                rest = memory[channel.place + 1] & ((half << 1) - 1)
                above = 64 - shift
                word = (word & ((1 << above) - 1)) | (((rest ^ half) - half) << above)
        ring[first + n] = word & channel.mask
    fired = 0
    for n in range(len(triggers)):
        fired += _fires(triggers[n], ring[first + triggers[n].channel])
    return fired


def _fires(trigger: WatchedChannel, word: int) -> int:
    """Return 1 if a trigger fires with this sample, else 0; `trigger.state` is updated."""
    key = (word ^ trigger.sign) - trigger.sign
    if key < 0:
        key = key ^ trigger.flip
    key = key ^ trigger.turn
    if key < trigger.least or key > trigger.most:
        trigger.state = -1
        return 0
    holds = 0
    if trigger.low <= key and key <= trigger.high:
        holds = 1
    if trigger.inverted:
        holds = 1 - holds
    before = trigger.state
    trigger.state = holds
    if trigger.event == TriggerEvent.HOLDS:
        return holds
    if before < 0:
        return 0
    if trigger.event == TriggerEvent.BEGINS:
        return holds * (1 - before)
    return abs(holds - before)


KERNEL = Kernel("scope", take_sample, {SampledChannel: SAMPLED, WatchedChannel: WATCHED})
