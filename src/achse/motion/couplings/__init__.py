"""Laws by which an axis follows others, one module for each; `table` has them all.

Read `table` first, which lists the parts of a law, then `linear`, the simplest law. `masters` has
the leading values of an axis, `guard` refuses set points that an axis cannot follow. `cams` and
`cam_checks` follow tables; `flying_saws` come to a moving master and run with it.
"""
