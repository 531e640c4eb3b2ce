"""The rule of ``drive.sources``: amplitude and phase of the source at each driven transducer."""

import cmath
import math
import re
from dataclasses import dataclass

from studies.refusal import Refusals, SceneError, shown
from studies.scene.rule import Rule
from studies.scene.rule.numbers import MAX_SIZE

PHASED = re.compile(r"\s*(?P<amplitude>\S+)\s+at\s+(?P<phase>\S+)\s*(?P<unit>deg|rad)\s*")
QUARTERS = {0.0: 1.0, 90.0: 1j, 180.0: -1.0, 270.0: -1j}  # exact, where cos 90 deg is 6e-17


@dataclass(frozen=True)
class Sources(Rule):
    """By name of a transducer: a number, "amplitude at phase deg", or [real, imaginary part]."""

    def read(self, path, value):
        """Return pairs of name and complex amplitude, in the order given."""
        if isinstance(value, tuple):
            value = dict(value)
        if not isinstance(value, dict) or not value:
            raise SceneError(path, f"must be {self.expected}, got {shown(value)}")
        refusals, pairs = Refusals(), []
        for name, amplitude in value.items():
            with refusals:
                pairs.append((name, _amplitude(f"{path}.{name}", amplitude)))
        refusals.raise_all()
        if not any(amplitude for _, amplitude in pairs):
            raise SceneError(path, f"must have at least one amplitude that is not 0, got {shown(value)}")
        return tuple(pairs)

    def written(self, value):
        return {
            name: [amplitude.real, amplitude.imag] if amplitude.imag else amplitude.real
            for name, amplitude in value
        }

    @property
    def expected(self):
        return 'a table of transducers such as { left = 1, right = "0.5 at 90 deg" }'

    def schema(self):
        number = {"type": "number", "minimum": -MAX_SIZE, "maximum": MAX_SIZE}
        either = [
            number,
            {"type": "string", "pattern": r"^\s*\S+\s+at\s+\S+\s*(deg|rad)\s*$"},
            {"type": "array", "items": number, "minItems": 2, "maxItems": 2},
        ]
        return {"type": "object", "minProperties": 1, "additionalProperties": {"anyOf": either}}


def _amplitude(path: str, value) -> complex:
    """Return a source's complex amplitude, relative to the drive voltage."""
    rule = 'must be a number, "amplitude at phase deg" such as "0.5 at 90 deg", or [real, imaginary part]'
    parts = [value] if isinstance(value, (int, float, complex)) else value
    if isinstance(value, str):
        found = PHASED.fullmatch(value)
        try:
            size, phase = (float(found[name]) for name in ("amplitude", "phase")) if found else (None, None)
        except ValueError:
            found = None
        if found is None or size < 0:
            raise SceneError(path, f"{rule}, got {shown(value)}")
        degrees = phase if found["unit"] == "deg" else math.degrees(phase)
        exact = QUARTERS.get(degrees % 360.0)
        amplitude = size * exact if exact is not None else cmath.rect(size, math.radians(degrees))
        parts = [amplitude]
    if not isinstance(parts, (list, tuple)) or len(parts) not in (1, 2):
        raise SceneError(path, f"{rule}, got {shown(value)}")
    if any(isinstance(part, bool) or not isinstance(part, (int, float, complex)) for part in parts):
        raise SceneError(path, f"{rule}, got {shown(value)}")
    amplitude = complex(*parts)
    if not (cmath.isfinite(amplitude) and abs(amplitude) <= MAX_SIZE):
        raise SceneError(path, f"must be finite, got {shown(value)}")
    return amplitude
