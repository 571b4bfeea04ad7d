"""Groups: axes that move together. A kind of group is a file with a class; `table` names it.

Read `group` first, the base of all. `ptp` is the group of a single axis, `fifo` plays rows of set
points (`interpolation`), `kinematic` couples axes by a law of `kinematics`, `path_group` drives
along a path (`path_parameters`, `path_view`, `reach`, `way_back` are parts of it). `parameters`
configure a group.

Source: 002 §6.4.3.
"""
