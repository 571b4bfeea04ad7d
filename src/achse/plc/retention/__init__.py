"""Values that outlive their program: RETAIN and PERSISTENT data, and those of an online change.

Read `layout` (which bytes mean something in one memory only), then `retained` and `remains` (from
one start to the next) and `past` (from one declaration to the next).
"""
