"""EtherCAT: frames, slave controllers with what sits behind them, and segments of slaves."""
