"""Periodic motions: their search by shooting, sticking motions in harmonics, and long runs until a motion settles."""
