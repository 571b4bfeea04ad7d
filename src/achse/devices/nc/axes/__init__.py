"""Services of an axis with its encoders, controllers and drives, but for its functions.

Read `states` first: rows bound to what an axis does. `parameters` has those that clients write,
`parameter_set` all of them in one answer; `encoder`, `controller` and `drive` are the elements of
an axis, `touch_probe` belongs to the encoder. `structures` has the members of the structures that
`cyclic` exchanges; `io_structures` and `terminals` are the way to drives and terminals.
"""
