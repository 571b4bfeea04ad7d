"""Numbers of the station's own ADS service that its clients use too."""

SERVICE_PORT = 26_000
"""AMS port, in the range for servers of customers (26000 … 26999)."""

ONLINE_CHANGE = 0xFA04
"""Index group; offset: AMS port of a PLC, 0 for all. Sources are read again and taken over."""

MISSING_CONDITION = 0xFA06
"""Index group; offset: id of an axis. The text says what keeps its drive from being ready."""
