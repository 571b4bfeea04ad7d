"""A router without devices: many programs of a computer share one connection per target.

Read `gateway` first, the composition: router, listeners, targets. `target` is the link to one
target: its NetId, its route to us, and whether it is alive. `configuration` has the keys of a
router.toml, `requests` sends the router's own requests, `registration` adds a route to us at a
target. Neither motion nor NC nor PLC is loaded.
"""
