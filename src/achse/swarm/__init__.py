"""The swarm: a whole world from one seed, run in virtual time, and invariants that hold in it.

Read `world` first: what a world is. `drawing` draws one, with `operators` and `program` for its
parts, from the numbers of `draws`. `play` runs it: a `life` of a station, `clients` on the `road`,
the `disk`. `invariants` is the table of what must hold; `motion_checks`, `motion_watch`, `talk` and
`resources` look after it. `shrink` makes a failing world small.
"""
