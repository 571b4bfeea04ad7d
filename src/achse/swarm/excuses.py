"""Excuses: cases in which an invariant is not checked, each with its reason and how often it was.

A count says how many violations a reason has hidden, or how many cycles were left out. A reason
that is often used hides much, and is the next one to make narrower.
"""

from collections.abc import Mapping

EXCUSES: Mapping[str, str] = {
    "request_in_fault": "a fault of frames for requests was active while the request was under way",
    "sample_in_fault": "a fault of frames for notifications, or of links, was active",
    "unknown_sample": "the answer with the handle of the subscription was hit by a fault",
    "sample_gap": "restart, online change, or samples that are counted as lost",
    "abrupt_cycle": "a reset in motion, a new actual position, a loop that opens or closes",
}
"""Reason of each excuse, by its name."""


def excuse_rows(counts: Mapping[str, int]) -> list[str]:
    """Return a line for each excuse that was used: name, count and reason."""
    return [
        f"  excused {counts[name]} times, {name}: {reason}"
        for name, reason in EXCUSES.items()
        if counts.get(name)
    ]
