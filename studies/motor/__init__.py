"""Questions about the motor: velocity, regimes, load, steps, design maps and the pictures of a whole motor."""
