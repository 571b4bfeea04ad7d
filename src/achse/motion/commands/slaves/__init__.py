"""Commands that couple axes, and commands to slaves.

Read `couplings` first: coupling by parameters, decoupling and its follow-up motions. `cams` has
cam tables and the changes of a running cam, `synchronising` the universal flying saw, `phasing` the
phase shift of a slave.
"""
