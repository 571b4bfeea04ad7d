"""The client: asks ADS devices, ours and real ones."""
