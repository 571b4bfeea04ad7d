"""Kinematics: how the axes of a machine (ACS) and the places of its tool (MCS) belong together.

A law is a file with two functions, `forward(numbers, axes, places)` and `inverse(numbers, places,
axes)`, and a row of `table` that names it and its numbers. Both write what they find into their
last argument and answer 1, or answer 0 where there is no solution. `inverse` finds the present
axes there: of several solutions it takes the one of the present pose. Lengths are in mm, angles in
degrees. They are plain typed functions in the language of `achse.native`; a user's Python file with
the same two functions is a law as well.
"""
