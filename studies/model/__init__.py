"""A scene as objects of ``fem`` and ``contact``: stator, transducers, drive, slider; numbers for automatic values."""
