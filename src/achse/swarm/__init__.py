"""The swarm: a whole world from one seed, run in virtual time, and invariants that hold in it.

Read `worlds` first: what a world is, and how it is drawn. `play` runs it: a `life` of a station,
`clients` on a `link`, the `disk`; `project` has worlds around the station of a user. `invariants`
is the table of what must hold; `motion`, `drive_watch`, `talk` and `resources` look
after it. `scenario` plays one seed, `campaign` many; `report` writes a failure down.
"""
