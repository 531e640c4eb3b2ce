"""Rules of the sources of a drive, apart from its circuit: they also check the block of a scene."""

from collections.abc import Iterator
from typing import Any

from fem.parameters import Parameters, finite_complex, shown


class SourceRules(Parameters):
    """Rules of `fem.Drive`."""

    sources: Any  # amplitudes by name: a mapping, or pairs

    def check_sources(self) -> Iterator[tuple[str, str]]:
        """Require at least one source that is not 0."""
        if self.sources is None:
            return
        sources = dict(self.sources)
        for name, amplitude in sources.items():
            finite_complex(f"drive.sources.{name}", amplitude)
        if not any(sources.values()):
            yield "sources", f"must have at least one amplitude that is not 0, got {shown(sources)}"
