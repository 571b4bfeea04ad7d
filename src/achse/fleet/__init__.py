"""Fleets: many stations of one template, in processes that are looked after."""
