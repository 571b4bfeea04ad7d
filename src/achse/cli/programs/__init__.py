"""Commands about part programs: `achse channel` runs them, `achse gcode` reads files.

Read `channel` first: a program on the interpreter of an NC. `gcode` needs no machine: it checks a
file, draws its path and computes its time, for which `gcode_run` runs it on a path alone.
"""
