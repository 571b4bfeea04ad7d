"""Sweeps: thousands of runs of one scenario in virtual time, over a Dask cluster."""

from achse.sweeps.cluster import Sweep, sweep
from achse.sweeps.plan import Run, SweepError, SweepParameter, SweepPlan

__all__ = ["Run", "Sweep", "SweepError", "SweepParameter", "SweepPlan", "sweep"]
