"""Commands that start: `achse new`, `run`, `demo`, `wait`, `stop`, `fleet`, `web`.

Read `run` first: one station in this process. `detached` starts it in a process of its own, which
`wait` and `stop` find again. `fleet` starts many, with `fleet_record` for the commands that find
them, `fleet_table` for their state and `fleet_export` for containers. `new` writes the files that
the others start from; `demo` walks through all of it, and `next_steps` names what to try next.
"""
