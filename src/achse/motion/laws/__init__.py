"""Laws of motion: how a slave goes from point to point of a motion function, over its master.

`table` has the laws, `element` their common form (values and derivatives at a place), `extremes`
their largest velocities and accelerations.
"""
