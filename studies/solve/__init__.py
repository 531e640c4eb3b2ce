"""The answers to a scene: motion of the stator's surface, contact at each level, errors, ripple, bursts."""
