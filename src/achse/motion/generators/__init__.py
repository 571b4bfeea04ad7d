"""Generators: each way of making set points is a module of its own and a row of `table`.

Read `table` first, then `moves` (jobs, by `achse.motion.setpoints`) and `velocity_steps`, a short
one. A generator has a function `step` for its share of a cycle.
"""
