"""Laws by which an axis follows others, one module for each; `table` has them all.

Read `table` first, which lists the parts of a law, then `linear`, the simplest law. `masters` has
the leading values of an axis, `guard` refuses set points that an axis cannot follow. `cams` and
`cam_checks` follow tables; `approach`, `chase`, `course` and `characteristic` bring a flying saw to
its master, `sync_checks` refuses courses of it.
"""
