"""Values that outlive their program: RETAIN and PERSISTENT data, and those of an online change.

Read `layout` (bytes that mean something in one memory only), then `retained` and `retained_state`
(from one start to the next) and `online_change_snapshot` (from one declaration to the next).
"""
