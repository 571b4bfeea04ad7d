"""AMS/TCP, the side that dials: connections along the routes of the router.

Read `uplinks` first, then `uplink`, the way along one route: what waits, when it is dialled, what
is refused. `dialled` is the peer at its far end, `nat` one that has another NetId than the one by
which the station knows it. `host_names` looks up the names in routes.
"""
