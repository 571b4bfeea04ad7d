"""Carriers of AMS frames: each one an endpoint of the router."""
