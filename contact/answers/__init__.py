"""What is asked of a contact: steady states, bursts, waveforms, thresholds, load lines, steps."""
