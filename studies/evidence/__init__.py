"""What shows that the rest can be trusted: error against run time, calibration, extremes, neglected terms, peers."""
