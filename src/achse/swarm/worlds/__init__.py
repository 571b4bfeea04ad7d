"""Worlds as plain data: drawn from a seed, and made small when they fail.

Read `world` first. `drawing` draws one, with `operators` and `program` for its parts, from the
numbers of `draws`; `shrink` looks for a smaller one that fails in the same way.
"""
