"""Service rows of the NC by area: ring 0, channels, groups, axes and their parts, tables."""
