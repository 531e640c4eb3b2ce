"""Options that several commands share, as argparse takes them."""

from argparse import ArgumentParser

OPTIONS: dict[str, dict] = {
    "scene": {"metavar": "SCENE", "help": "a path or a shipped name"},
    "--voltage": {"metavar": "LIST", "help": "peak voltages: START:STOP:N or a list with commas"},
    "--set": {
        "action": "append",
        "default": [],
        "metavar": "KEY=VALUE",
        "help": 'change one key, e.g. slider.mass=1e-4 or transducer.1.center="900 mm"',
    },
    "--over": {
        "action": "append",
        "default": [],
        "metavar": "KEY=VALUES",
        "help": 'an axis: START:STOP:N, START:STOP:N:log or a list, e.g. slider.preload="1 mN:100 mN:50"',
    },
    "--tolerance": {"metavar": "T", "help": "bound of the relative error of the last quantity (1e-3)"},
    "--workers": {"type": int, "default": 1, "metavar": "N", "help": "processes on this machine (1: this one)"},
    "--explain": {
        "action": "store_true",
        "help": "print what would be computed, with its size, time and memory, and stop",
    },
    "--netcdf": {"action": "store_true", "help": "also a netCDF file, for xarray and other readers of arrays"},
    "--no-plot": {"action": "store_true", "help": "draw nothing"},
}


def add_shared(parser: ArgumentParser, *names: str) -> None:
    """Add shared options to the parser of a command, in the order of their names."""
    for name in names:
        parser.add_argument(name, **OPTIONS[name])
