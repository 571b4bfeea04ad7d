"""AMS ports of services that each router has.

Source: 000 §3.2.2 (1, 100, 110, 10000).
"""

ROUTER_PORT = 1
"""The router's own figures."""

LOGGER_PORT = 100
"""Messages that programs log."""

EVENT_LOGGER_PORT = 110
"""Events and alarms."""

SYSTEM_PORT = 10_000
"""The system service: state, files, routes."""
