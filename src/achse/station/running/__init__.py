"""A station in operation: its states, its cycle in real time, and its figures.

Read `states` first: RUN, CONFIG and the way between them; `state_requests` lets clients change
them, `collection` frees what a restart leaves. `operation` paces the cycle and opens the network.
`statistics` are figures about connections, subscriptions and the cycle, `metrics` serves them.
"""
