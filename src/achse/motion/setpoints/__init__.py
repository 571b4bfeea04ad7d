"""Set points of an axis: from the job to position, velocity and acceleration of each cycle.

Read `setpoint` first: jobs begin and end, profiles are walked. `jobs` has the request of a job,
`targets` its target and the border to the next one, `planning` its profile, `dynamics` the ramps of
an axis, `limits` the soft limits. `superposition` and `phasing` are motions on top of the job.
Other ways of making set points are in `achse.motion.generators`. All is kernel source.
"""
