"""Motion under watch: each set point of each axis against the invariants of motion.

Read `step` first, what is seen of an axis in a cycle; `checks` check it, `kernel` does both for all
axes of an NC, as it is or as machine code. `watch` is the phase of a station that calls it.
"""
