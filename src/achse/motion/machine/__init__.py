"""The simulated machine: what is behind the hardware port instead of a bus.

The NC knows none of this. It reads and writes the I/O structures of `achse.motion.port`; here is
what they lead to, with parameters of its own: motor and load, encoders and drives with their
scaling, directions and dead times, cams, marks, limit switches and inputs.
"""
