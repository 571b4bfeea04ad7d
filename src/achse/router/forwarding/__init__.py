"""Forwarding: many clients over one connection to a router with targets.

Read `forwarding` first, then `pending` (requests under way) and `ledger` (what clients hold);
`restoring` and `handles` make that again behind a connection that was lost.
"""

from achse.router.forwarding.forwarding import Forwarding

__all__ = ["Forwarding"]
