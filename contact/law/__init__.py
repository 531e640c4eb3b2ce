"""The force laws of a contact: normal force, tangential force, transitions between their regimes."""
