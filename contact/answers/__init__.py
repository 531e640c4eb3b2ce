"""Answers about a contact: steady states, bursts, waveforms, thresholds, load lines, steps."""
