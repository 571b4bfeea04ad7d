"""A station in operation: its figures, and their port for Prometheus.

Read `statistics` first: connections, subscriptions, handles and the cycle as numbers; `metrics`
serves them.
"""
