"""The physics and geometry of axes: records, set-point profiles, couplings, control, simulation."""
