"""What emulated boards share: the plant behind them, their links, faults and process."""
