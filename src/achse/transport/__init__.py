"""Carriers of AMS frames: each one an endpoint of the router.

Read `connections` first: the peer at the far end of any connection, without a socket. Then `tcp`,
the listener that lets peers in, and `uplinks`, which dials them along the routes. `secure` puts
TLS and the proofs of identity between the two; `serial` and `mqtt` carry the same frames over a
line and through a broker. Beside them are `udp` (discovery), `net_id_query` and `own_address`,
and what carries other frames: `ethernet` with `link_state` for fieldbuses, and `modbus`. `reason`
and `file_lock` serve all.
"""
