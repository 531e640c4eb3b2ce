"""The motion from event to event, exactly."""
