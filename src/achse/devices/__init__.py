"""The faces: one module or folder per ADS device, service rows bound to the state of a wing."""
