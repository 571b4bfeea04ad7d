"""The composition root: configuration, clock, cycle and links of one station."""
