"""The motion in fixed steps."""
