r"""A tangential law from a user's own file, in SI units. The solvers call its machine code by address.

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

Whole numbers are compiled as floats (`law.whole_numbers`), and when a law is read its compiled functions are compared
with Python's at approaches, speeds and deformations over their whole range: a law that numba understands otherwise than
Python is refused.

The solvers' kernels are compiled once for all such laws, and each law's functions by themselves, within a second. The
text of the file is part of the name under which their machine code is kept: an edited law is compiled anew.
"""

import ctypes
import hashlib
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import ClassVar, NamedTuple, Self

import numpy as np

from contact.codes import Tangential
from contact.exceptions import InputError
from contact.jit.compiled import callback, formula
from contact.law import elastic
from contact.law.normal import LAWS, SHAPES, load, unit_load
from contact.law.protocol import Law, slip_limit
from contact.law.table import TabulatedForce
from contact.law.whole_numbers import with_floats

# the arguments of the functions of a file
ARGUMENTS = {
    "sliding": ("approach", "normal_force", "slip_speed", "contact"),
    "limit": ("approach", "normal_force", "contact"),
    "stuck": ("approach", "normal_force", "deformation", "contact"),
}
# Functions of `protocol.Law` that a user's file may not define: guards, transitions and memory
RESERVED = ("force", "guard", "guard_rate", "follow", "memory")
# Indices in `Law.numbers`: the fields of `Contact`, and behind them K
EFFECTIVE_MODULUS, TANGENTIAL_MODULUS, STIFFNESS = 2, 3, 5
# Smallest scaled approach at which the coefficient is evaluated; relative step of differences
CLOSEST, STEP = 1e-9, 1e-5
# Approaches in m and slip speeds in m/s at which a law is tried when it is read
TRIED_APPROACHES, TRIED_SPEEDS = np.logspace(-12, -6, 25), (0.0, 1e-3, 1.0)
# Approaches in m, slip speeds in m/s and deformations over the slip limit at which compiled functions are compared with
# Python's. They may differ by rounding, of a law with a cancellation by more.
COMPARED_APPROACHES, COMPARED_SPEEDS = np.logspace(-13, -4.3, 14), (0.0, *np.logspace(-8, 1.3, 14))
COMPARED_DEFORMATIONS, ROUNDING = (0.0, 0.01, 0.2, 0.5, 0.9, 1.0), 1e-9
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
class UserText:
    """The text of a user's file of Python functions.

    Attributes
    ----------
    name : str
        Of the file.
    source : str
        Its text.
    """

    name: str
    source: str
    key: ClassVar[str] = "slider.law"  # of a scene that names the file

    @classmethod
    def of(cls, source: "UserText | str | Path | ModuleType") -> Self:
        """Return the law of a file or of a module."""
        if isinstance(source, cls):
            return source
        if isinstance(source, ModuleType):
            return cls(source.__name__, inspect.getsource(source))
        path = Path(str(source))
        try:
            return cls(path.name, path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(cls.key, f"names {path}, which cannot be read: {error}") from None

    @property
    def functions(self) -> dict:
        """The functions of the file by name."""
        return _functions(self.name, self.source, self.key)

    def refuse_arguments(self, arguments: dict[str, tuple[str, ...]], required: str) -> None:
        """Raise an InputError unless the file has the required function, and all with their arguments."""
        for name, expected in arguments.items():
            function = self.functions.get(name)
            signature = f"{name}({', '.join(expected)})"
            if function is None and name == required:
                raise InputError(self.key, f"must define {signature}, but {self.name} has none")
            if function is not None and len(inspect.signature(_plain(function)).parameters) != len(expected):
                raise InputError(self.key, f"must define {signature}, but {self.name} takes other arguments")


@dataclass(frozen=True)
class UserLaw(UserText):
    """The text of a user's law; see the module's text for what it holds.

    Examples
    --------
    >>> text = "def sliding(approach, normal_force, slip_speed, contact): return 0.1 * normal_force"
    >>> UserLaw("plain.py", text).functions["sliding"](1e-9, 2.0, 0.0, None)
    0.2
    """

    def __post_init__(self):
        for name in RESERVED:
            if name in self.functions:
                rule = f"must not define {name}, but {self.name} does: it may have {', '.join(ARGUMENTS)}"
                raise InputError("slider.law", rule)
        self.refuse_arguments(ARGUMENTS, "sliding")

    @property
    def floats(self) -> "UserLaw":
        """The law with whole numbers as floats, as it is compiled first."""
        return UserLaw(self.name, with_floats(self.source))


def _plain(function):
    """Return the Python function of one that kernels can call."""
    return getattr(function, "function", function)


@lru_cache(64)
def _functions(name, source, key):
    """Return the functions of a text, each one that kernels can call."""
    module = ModuleType(f"law_{_digest(source)}")
    try:
        exec(compile(source, name, "exec"), vars(module))
    except Exception as error:
        raise InputError(key, f"names {name}, which cannot be run: {type(error).__name__}: {error}") from None
    functions = {
        key: formula(each)
        for key, each in vars(module).items()
        if isinstance(each, FunctionType) and each.__module__ == module.__name__
    }
    vars(module).update(functions)
    return functions


@dataclass(frozen=True)
class UserForce(UserText):
    """The text of a user's normal law: `force(approach, contact)` in N, at approaches in m from first touch.

    It rises from 0, and at first touch as the shape's own does: as z^1.5 of a sphere, as z of a punch. `contact` holds
    the same numbers as for a `UserLaw`. It is evaluated by Python and tabulated (`law.table`), so that one kernel
    serves all such laws.

    Examples
    --------
    >>> text = "def force(approach, contact): return 3e9 * approach**1.5"
    >>> UserForce("plain.py", text).functions["force"](1e-8, None)
    0.003
    """

    key: ClassVar[str] = "slider.normal_law"

    def __post_init__(self):
        self.refuse_arguments({"force": ("approach", "contact")}, "force")

    def table(self, contact: Contact, scale: float, end: float) -> TabulatedForce:
        """Return the table of a contact; see `TabulatedForce.of`."""
        return _table(self, contact, scale, end)


@lru_cache(64)
def _table(user, contact, scale, end):
    function = user.functions["force"]

    def force(approach):
        try:
            return float(function(approach, contact))
        except Exception as error:
            why = f"names {user.name}, whose force cannot be evaluated: {type(error).__name__}: {error}"
            raise InputError(user.key, why) from None

    return TabulatedForce.of(force, scale=scale, end=end, shape=SHAPES[int(contact.punch)])


@lru_cache(64)
def tried(user: UserLaw, contact: Contact, stiffness: float) -> tuple[float, float, bool, bool]:
    """Return (coefficient at 1 nm, largest rise of the slip limit with the approach, rated, bent) of a law.

    Raises an InputError for forces that are negative or not finite, or that differ between Python and numba.
    """
    law, ratio = LAWS[int(contact.punch)], contact.effective_modulus / (4.0 * contact.tangential_modulus)
    normal_forces = stiffness * load(TRIED_APPROACHES, law)
    trials = list(zip(TRIED_APPROACHES, normal_forces, strict=True))
    forces = np.array([[_value(user, "sliding", z, p, w, contact) for w in TRIED_SPEEDS] for z, p in trials])
    coefficients = forces[:, 0] / normal_forces
    slopes = ratio * coefficients  # X/z
    if "limit" in user.functions:
        slopes = np.array([_value(user, "limit", z, p, contact) / z for z, p in trials])
    bent = any(np.ptp(each) > 1e-12 * np.max(each) for each in (slopes, coefficients))
    rated = bool(np.max(np.ptp(forces, axis=1)) > 1e-12 * np.max(forces))
    _compiled(user, contact, stiffness)
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


@lru_cache(64)
def _compiled(user, contact, stiffness) -> "Callbacks":
    """Return the functions that kernels call, which give what Python gives; an InputError where there are none.

    With whole numbers as floats, or as they stand where that does not serve: a float is no index.
    """
    failures = []
    for text in (user.floats, user):
        callbacks = _callbacks(text)
        difference = _difference(user, callbacks, contact, stiffness)
        if difference is None:
            return callbacks
        failures.append(difference)
    raise InputError("slider.law", failures[-1])


def _difference(user, callbacks, contact, stiffness) -> str | None:
    """Return where a law's compiled functions differ from Python's, None where they agree."""
    for name, callback_of in callbacks._asdict().items():
        if callback_of is None:
            continue
        try:
            machine = _called_by_address(callback_of)
        except Exception as error:  # numba has many kinds
            why = " ".join(str(error).split())[:200]
            return f"names {user.name}, whose {name} numba cannot compile: {type(error).__name__}: {why}"
        for arguments in _compared(user, name, contact, stiffness):
            try:
                expected = float(user.functions[name](*arguments, contact))
            except Exception:  # beyond the domain of the law itself, such as log(0) or the end of a table
                continue
            found = machine(*arguments, *contact)
            if math.isfinite(expected) and not abs(found - expected) <= ROUNDING * abs(expected):
                where = ", ".join(f"{each:.3g}" for each in arguments)
                values = f"{name}({where}, contact) is {expected:.6g}, compiled by numba {found:.6g}"
                return (
                    f"must be the same in Python and compiled, but in {user.name} {values}: whole numbers are compiled "
                    "as integers (write 10.0, not 10), and a function must not change what it reads"
                )
    return None


def _called_by_address(callback_of):
    """Return a function that calls the machine code of a callback; Python's own without a compiler."""
    if not hasattr(callback_of, "address"):
        return callback_of
    return ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * callback_of.count)(callback_of.address)


def _compared(user, name, contact, stiffness):
    """Yield the arguments before ``contact`` at which a function is compared."""
    ratio = contact.effective_modulus / (4.0 * contact.tangential_modulus)
    for approach in COMPARED_APPROACHES.tolist():
        normal_force = float(stiffness * load(approach, LAWS[int(contact.punch)]))
        if name == "limit":
            yield approach, normal_force
        elif name == "sliding":
            yield from ((approach, normal_force, float(speed)) for speed in COMPARED_SPEEDS)
        else:
            try:
                if "limit" in user.functions:
                    limit = float(user.functions["limit"](approach, normal_force, contact))
                else:
                    limit = ratio * approach * user.functions["sliding"](approach, normal_force, 0.0, contact)
                    limit /= normal_force
            except Exception:
                continue
            yield from ((approach, normal_force, share * limit) for share in COMPARED_DEFORMATIONS)


def user_law(user: UserLaw, contact: Contact, stiffness: float) -> Law:
    """Return the law of a text for a contact with P = K p(z), K = `stiffness`."""
    _, _, rated, bent = tried(user, contact, stiffness)
    callbacks = _compiled(user, contact, stiffness)
    return elastic.coulomb(Tangential.ELASTIC)._replace(
        rated=int(rated), bent=int(bent), numbers=np.array([*contact, stiffness]), callbacks=callbacks,
        **_functions_of(user, bent),
    )  # fmt: skip


def _functions_of(user, bent):
    """Return the functions by field of `Law` that are not those of the elastic law."""
    functions = {"sliding": sliding, "deformation": elastic.deformation}
    if bent or not user.functions.keys().isdisjoint(ARGUMENTS.keys() - {"sliding"}):
        ratio = limit_ratio if "limit" in user.functions else elastic_ratio
        functions |= {"coefficient": coefficient, "limit_ratio": ratio, "limit_rate": limit_rate, "back": back}
    if "stuck" in user.functions:
        functions |= {"stuck": stuck, "deformation": deformation, "energy": energy}
    return functions


class Callbacks(NamedTuple):
    """A user's functions with the numbers of `Contact` as their last arguments; None where the file has none."""

    sliding: Callable
    limit: Callable | None
    stuck: Callable | None


@lru_cache(64)
def _callbacks(user):
    """Return a user's functions as kernels call them; of one text always the same."""
    own = user.functions

    def called(name):
        return callback(f"{__name__}-{name}-{_digest(user.source)}")

    @called("sliding")
    def sliding(approach, normal_force, slip_speed, friction, radius, effective_modulus, tangential_modulus, punch):
        contact = Contact(friction, radius, effective_modulus, tangential_modulus, punch)
        return own_sliding(approach, normal_force, slip_speed, contact)

    @called("limit")
    def limit(approach, normal_force, friction, radius, effective_modulus, tangential_modulus, punch):
        contact = Contact(friction, radius, effective_modulus, tangential_modulus, punch)
        return own_limit(approach, normal_force, contact)

    @called("stuck")
    def stuck(approach, normal_force, deformation, friction, radius, effective_modulus, tangential_modulus, punch):
        contact = Contact(friction, radius, effective_modulus, tangential_modulus, punch)
        return own_stuck(approach, normal_force, deformation, contact)

    own_sliding, own_limit, own_stuck = (own.get(name) for name in ARGUMENTS)
    return Callbacks(sliding, own_limit and limit, own_stuck and stuck)


def _digest(source):
    return hashlib.sha256(source.encode()).hexdigest()[:16]


@formula
def force_unit(problem):
    """Return the force in N of a scaled force over kappa of 1."""
    return problem.law.numbers[STIFFNESS] * unit_load(problem.normal, problem.length)


@formula
def sliding(problem, z, w):
    """Return the sliding force over kappa."""
    up, unit, n = 0.5 * (z + abs(z)), force_unit(problem), problem.law.numbers
    normal_force = unit * load(up, problem.normal)
    speed = w * problem.length * problem.omega
    own = problem.law.callbacks.sliding
    return own(up * problem.length, normal_force, speed, n[0], n[1], n[2], n[3], n[4]) / unit


@formula
def coefficient(problem, z):
    """Return a coefficient of friction that depends on the approach."""
    up, n = max(z, CLOSEST), problem.law.numbers
    normal_force = force_unit(problem) * load(up, problem.normal)
    own = problem.law.callbacks.sliding
    return own(up * problem.length, normal_force, 0.0, n[0], n[1], n[2], n[3], n[4]) / normal_force


@formula
def limit_ratio(problem, z):
    """Return X/z of a user's slip limit."""
    up, n = max(z, CLOSEST), problem.law.numbers
    normal_force = force_unit(problem) * load(up, problem.normal)
    own = problem.law.callbacks.limit
    return own(up * problem.length, normal_force, n[0], n[1], n[2], n[3], n[4]) / (up * problem.length)


@formula
def elastic_ratio(problem, z):
    """Return X/z of the elastic spring with a coefficient that depends on the approach."""
    n = problem.law.numbers
    return coefficient(problem, z) * n[EFFECTIVE_MODULUS] / (4.0 * n[TANGENTIAL_MODULUS])


@formula
def limit_rate(problem, z):
    """Return dX/dz, by a difference."""
    up = max(z, 2.0 * CLOSEST)
    step = STEP * up
    return (slip_limit(problem, up + step) - slip_limit(problem, up - step)) / (2.0 * step)


@formula
def back(problem, z, x):
    """Return the derivative of the spring's energy in the approach, by a difference."""
    step, law = STEP * z, problem.law
    return (law.energy(problem, z + step, x) - law.energy(problem, z - step, x)) / (2.0 * step)


@formula
def stuck(problem, z, x):
    """Return the force over kappa of a user's spring."""
    up, unit, n = max(z, CLOSEST), force_unit(problem), problem.law.numbers
    normal_force, size = unit * load(up, problem.normal), abs(x) * problem.length
    own = problem.law.callbacks.stuck
    force = own(up * problem.length, normal_force, size, n[0], n[1], n[2], n[3], n[4]) / unit
    return force if x >= 0.0 else -force


@formula
def deformation(problem, z, force):
    """Return the deformation at which a user's spring carries a force, by bisection."""
    low, high = 0.0, slip_limit(problem, z)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if stuck(problem, z, middle) < force:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@formula
def energy(problem, z, x):
    """Return the energy of a user's spring, by quadrature."""
    # int_0^x Q dx with x = limit (1 - s^2), because the force may have a square root at the limit
    limit, total = max(slip_limit(problem, z), x), 0.0
    start = math.sqrt(max(1.0 - x / limit, 0.0)) if limit > 0.0 else 1.0
    for k in range(len(POINT)):
        s = start + (1.0 - start) * 0.5 * (POINT[k] + 1.0)
        total += WEIGHT[k] * stuck(problem, z, limit * (1.0 - s * s)) * 2.0 * s * limit
    return 0.5 * (1.0 - start) * total
