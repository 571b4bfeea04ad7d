"""Control loop of an axis: from the I/O of the encoder to the output of the drive.

Read in the order of the cycle: `encoder` (actual values), `signals` (latches, touch probes, homing
cam), `controller` (following error and output), `drive` (output to the I/O, `curves` being its
characteristics). `discrete` replaces controller and drive for two-speed drives and stepper motors,
`open_loop` lets the set point follow the axis while no position is controlled.
`achse.motion.monitoring` supervises all of it.
"""
