"""Known frames: forwarded by their first bytes, without decoding."""
