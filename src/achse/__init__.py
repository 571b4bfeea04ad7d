"""achse: a motion station in Python, speaking ADS/AMS as the real ones do."""

__version__ = "0.1.0"
