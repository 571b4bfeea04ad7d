"""Flying saws: slaves that come to a moving master and run with it.

Read `flying_saw` first (types 2 and 3 begin by velocity or position), then `approach`, the ways to
the master that all flying saws share: over the master, or in time by `chase`. `synchronising` has
the universal flying saw, whose `course` is planned and refused by `sync_checks` before it begins;
`characteristic` has the characteristic values of a course, `modulo_flying_saw` has the flying saw
of modulo axes.
"""
