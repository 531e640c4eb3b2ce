"""Published motors and figures, recomputed from what the papers state."""
