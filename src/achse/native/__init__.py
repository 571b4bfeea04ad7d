"""The ground of the kernels: records declared once, functions on them run as they are or compiled.

`achse.motion` and `achse.drive` each have a kernel: plain functions on records. `declare` makes
records from declarations, `compiled` turns the same functions into machine code.
"""
