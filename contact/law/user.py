r"""A tangential law from a user's own file: compiled into the solvers as the built-in ones are, in SI units.

A file of plain Python that numba compiles (numbers, `math` or `numpy` functions, own helper functions, constants):

    def sliding(approach, normal_force, slip_speed, contact):
        '''Tangential force in N of a contact that slips at slip_speed >= 0 in m/s; at 0 the largest that it holds.'''
        return 0.15 * normal_force + 2e-3 * contact.radius * approach / 1e-9 * slip_speed

and, to replace the spring of Cattaneo and Mindlin,

    def limit(approach, normal_force, contact):                  # m, the deformation at which slip begins
    def stuck(approach, normal_force, deformation, contact):     # N in stick, up to the limit

The exact method has events at contact, release, slip and stick. A kink of the user's functions in between is no event:
the segments around it are shortened until the truncation error is small enough, which takes about ten more segments per
kink. A file cannot define guards, transitions or a memory of its own; one that does is refused.

`contact` has friction_coefficient, radius, effective_modulus, tangential_modulus (SI units) and punch (0 or 1). Without
`limit` and `stuck` the spring is that of `law.elastic` with the coefficient sliding(..., 0, ...)/normal_force.

The text of the file is part of the name under which compiled kernels are kept: an edited law is compiled anew.
"""

import hashlib
import inspect
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import NamedTuple

import numpy as np

from contact.codes import Tangential
from contact.input_error import InputError
from contact.jit.compiled import formula
from contact.law import elastic
from contact.law.normal import load
from contact.law.protocol import Law, slip_limit

# the arguments of the functions of a file
ARGUMENTS = {
    "sliding": ("approach", "normal_force", "slip_speed", "contact"),
    "limit": ("approach", "normal_force", "contact"),
    "stuck": ("approach", "normal_force", "deformation", "contact"),
}
# Functions of `protocol.Law` that a user's file may not define: guards, transitions and memory
RESERVED = ("force", "guard", "guard_rate", "follow", "memory")
# Place of K in `Law.numbers`, behind the fields of `Contact`
STIFFNESS = 5
# Smallest scaled approach at which the coefficient is evaluated; relative step of differences
CLOSEST, STEP = 1e-9, 1e-5
# Approaches in m and slip speeds in m/s at which a law is tried when it is read
TRIED_APPROACHES, TRIED_SPEEDS = np.logspace(-12, -6, 25), (0.0, 1e-3, 1.0)
# Gauss-Legendre points of the energy of a spring of the user's own
POINT, WEIGHT = (tuple(map(float, each)) for each in np.polynomial.legendre.leggauss(16))


class Contact(NamedTuple):
    """Parameters of the contact that are passed to a user's functions."""

    friction_coefficient: float
    radius: float  # m
    # Pa
    effective_modulus: float
    tangential_modulus: float
    punch: float  # 1: a flat punch, 0: a sphere


@dataclass(frozen=True)
class UserLaw:
    """The text of a user's law; see the module's text for what it holds.

    Attributes
    ----------
    name : str
        Of the file.
    source : str
        Its text.

    Examples
    --------
    >>> text = "def sliding(approach, normal_force, slip_speed, contact): return 0.1 * normal_force"
    >>> UserLaw("plain.py", text).functions["sliding"](1e-9, 2.0, 0.0, None)
    0.2
    """

    name: str
    source: str

    def __post_init__(self):
        for name in RESERVED:
            if name in self.functions:
                rule = f"must not define {name}, but {self.name} does: it may have {', '.join(ARGUMENTS)}"
                raise InputError("slider.law", rule)
        for name, arguments in ARGUMENTS.items():
            function = self.functions.get(name)
            signature = f"{name}({', '.join(arguments)})"
            if function is None and name == "sliding":
                raise InputError("slider.law", f"must define {signature}, but {self.name} has none")
            if function is not None and len(inspect.signature(_plain(function)).parameters) != len(arguments):
                raise InputError("slider.law", f"must define {signature}, but {self.name} takes other arguments")

    @classmethod
    def of(cls, source: "UserLaw | str | Path | ModuleType") -> "UserLaw":
        """Return the law of a file or of a module."""
        if isinstance(source, cls):
            return source
        if isinstance(source, ModuleType):
            return cls(source.__name__, inspect.getsource(source))
        path = Path(str(source))
        try:
            return cls(path.name, path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise InputError("slider.law", f"names {path}, which cannot be read: {error}") from None

    @property
    def functions(self) -> dict:
        """The functions of the file by name."""
        return _functions(self.name, self.source)


def _plain(function):
    """Return the Python function of one that kernels can call."""
    return getattr(function, "function", function)


@lru_cache(64)
def _functions(name, source):
    """Return the functions of a text, each one that kernels can call."""
    module = ModuleType(f"law_{_digest(source)}")
    try:
        exec(compile(source, name, "exec"), vars(module))
    except Exception as error:
        raise InputError("slider.law", f"names {name}, which cannot be run: {type(error).__name__}: {error}") from None
    functions = {
        key: formula(each)
        for key, each in vars(module).items()
        if isinstance(each, FunctionType) and each.__module__ == module.__name__
    }
    vars(module).update(functions)
    return functions


@lru_cache(64)
def tried(user: UserLaw, contact: Contact, stiffness: float) -> tuple[float, float, bool, bool]:
    """Return (coefficient at 1 nm, largest rise of the slip limit with the approach, rated, bent) of a law.

    Raises an InputError for forces that are negative or not finite.
    """
    shape, ratio = int(contact.punch), contact.effective_modulus / (4.0 * contact.tangential_modulus)
    normal_forces = stiffness * load(TRIED_APPROACHES, shape)
    trials = list(zip(TRIED_APPROACHES, normal_forces, strict=True))
    forces = np.array([[_value(user, "sliding", z, p, w, contact) for w in TRIED_SPEEDS] for z, p in trials])
    coefficients = forces[:, 0] / normal_forces
    slopes = ratio * coefficients  # X/z
    if "limit" in user.functions:
        slopes = np.array([_value(user, "limit", z, p, contact) / z for z, p in trials])
    bent = any(np.ptp(each) > 1e-12 * np.max(each) for each in (slopes, coefficients))
    rated = bool(np.max(np.ptp(forces, axis=1)) > 1e-12 * np.max(forces))
    middle, limits = len(slopes) // 2, slopes * TRIED_APPROACHES
    rises = np.diff(limits, prepend=0.0) / np.diff(TRIED_APPROACHES, prepend=0.0)
    largest = 1.1 * max(np.max(rises), np.max(slopes)) if bent else slopes[middle]
    return float(coefficients[middle]), float(largest), rated, bool(bent)


def _value(user, name, *arguments):
    try:
        value = float(user.functions[name](*map(float, arguments[:-1]), arguments[-1]))
    except Exception as error:
        why = f"names {user.name}, whose {name} cannot be evaluated: {type(error).__name__}: {error}"
        raise InputError("slider.law", why) from None
    if not (math.isfinite(value) and value >= 0.0):
        where = f"{name} of {user.name} at an approach of {arguments[0]:.3g} m and {arguments[1]:.3g} N"
        raise InputError("slider.law", f"must give what is zero or positive, and finite, for {where}", value)
    return value


def user_law(user: UserLaw, contact: Contact, stiffness: float) -> Law:
    """Return the law of a text for a contact with P = K p(z), K = `stiffness`."""
    _, _, rated, bent = tried(user, contact, stiffness)
    return elastic.coulomb(Tangential.ELASTIC)._replace(
        rated=int(rated), bent=int(bent), numbers=np.array([*contact, stiffness]), **_compiled(user, bent)
    )


@lru_cache(64)
def _compiled(user, bent):
    """Return the functions by field of `Law` that are not those of the elastic law."""
    functions = {"sliding": _sliding(user), "deformation": elastic.deformation}
    if bent or not user.functions.keys().isdisjoint(("limit", "stuck")):
        functions |= _limit(user)
        functions |= {"back": _back(elastic.energy_stored, user)}
    if "stuck" in user.functions:
        functions |= _own_spring(user)
    return functions


def _digest(source):
    return hashlib.sha256(source.encode()).hexdigest()[:16]


def _named(function, user):
    """Return the compiled function; the law's text becomes part of the name under which its kernel is kept."""
    kernel = formula(function)
    if hasattr(kernel, "word"):
        kernel.word += _digest(user.source)
    return kernel


@formula
def contact_of(problem):
    """Return the numbers that a user's functions take."""
    n = problem.law.numbers
    return Contact(n[0], n[1], n[2], n[3], n[4])


@formula
def force_unit(problem):
    """Return the force in N of a scaled force over kappa of 1."""
    return problem.law.numbers[STIFFNESS] * load(problem.length, problem.shape)


def _sliding(user):
    """Return the function for the sliding force over kappa."""
    user_sliding = user.functions["sliding"]

    def sliding(problem, z, w):
        up = 0.5 * (z + abs(z))
        unit = force_unit(problem)
        normal_force = unit * load(up, problem.shape)
        speed = w * problem.length * problem.omega
        return user_sliding(up * problem.length, normal_force, speed, contact_of(problem)) / unit

    return _named(sliding, user)


def _limit(user):
    """Return the functions by field of `Law` of a coefficient and a slip limit that depend on the approach."""
    user_sliding = user.functions["sliding"]

    def coefficient(problem, z):
        up = max(z, CLOSEST)
        normal_force = force_unit(problem) * load(up, problem.shape)
        return user_sliding(up * problem.length, normal_force, 0.0, contact_of(problem)) / normal_force

    coefficient = _named(coefficient, user)
    if "limit" in user.functions:
        user_limit = user.functions["limit"]

        def limit_ratio(problem, z):
            up = max(z, CLOSEST)
            normal_force = force_unit(problem) * load(up, problem.shape)
            return user_limit(up * problem.length, normal_force, contact_of(problem)) / (up * problem.length)

    else:

        def limit_ratio(problem, z):
            contact = contact_of(problem)
            return coefficient(problem, z) * contact.effective_modulus / (4.0 * contact.tangential_modulus)

    limit_ratio = _named(limit_ratio, user)

    def limit_rate(problem, z):
        up = max(z, 2.0 * CLOSEST)
        step = STEP * up
        high, low = up + step, up - step
        return (limit_ratio(problem, high) * high - limit_ratio(problem, low) * low) / (2.0 * step)

    return {"coefficient": coefficient, "limit_ratio": limit_ratio, "limit_rate": _named(limit_rate, user)}


def _back(energy, user):
    """Return the derivative of a spring's energy in the approach, by a difference."""

    def back(problem, z, x):
        step = STEP * z
        return (energy(problem, z + step, x) - energy(problem, z - step, x)) / (2.0 * step)

    return _named(back, user)


def _own_spring(user):
    """Return the functions by field of `Law` of a user's spring: energy by quadrature, inverse by bisection."""
    user_stuck = user.functions["stuck"]

    def stuck(problem, z, x):
        up, unit = max(z, CLOSEST), force_unit(problem)
        size = abs(x) * problem.length
        force = user_stuck(up * problem.length, unit * load(up, problem.shape), size, contact_of(problem)) / unit
        return force if x >= 0.0 else -force

    stuck = _named(stuck, user)

    def deformation(problem, z, force):
        low, high = 0.0, slip_limit(problem, z)
        for _ in range(60):
            middle = 0.5 * (low + high)
            if stuck(problem, z, middle) < force:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def energy(problem, z, x):
        # int_0^x Q dx with x = limit (1 - s^2), because the force may have a square root at the limit
        limit, total = max(slip_limit(problem, z), x), 0.0
        start = math.sqrt(max(1.0 - x / limit, 0.0)) if limit > 0.0 else 1.0
        for k in range(len(POINT)):
            s = start + (1.0 - start) * 0.5 * (POINT[k] + 1.0)
            total += WEIGHT[k] * stuck(problem, z, limit * (1.0 - s * s)) * 2.0 * s * limit
        return 0.5 * (1.0 - start) * total

    energy = _named(energy, user)
    return {"stuck": stuck, "deformation": _named(deformation, user), "energy": energy, "back": _back(energy, user)}
