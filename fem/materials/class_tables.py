"""Tables of a crystal of a symmetry class from its independent constants, as data sheets and papers give them.

Which entries symmetry ties together: IEEE 176-1987, table 8; Nye, *Physical Properties of Crystals* (1957), chapters 7
to 9.  A compliance or d in engineering shear has a factor 2 where a constant without a shear index stands at one: s56 =
2 s14, s66 = 2 (s11 - s12), d16 = -2 d22.
"""

from collections.abc import Mapping

import numpy as np

from fem.parameters import InputError, choice

_TETRAGONAL = """c11 c12 c13  0   0   0
                 c12 c11 c13  0   0   0
                 c13 c13 c33  0   0   0
                  0   0   0  c44  0   0
                  0   0   0   0  c44  0
                  0   0   0   0   0  c66"""
_TRIGONAL = """c11  c12 c13  c14  0   0
               c12  c11 c13 -c14  0   0
               c13  c13 c33   0   0   0
               c14 -c14  0   c44  0   0
                0    0   0    0  c44 2c14
                0    0   0    0 2c14 c66"""
_CUBIC = _TETRAGONAL.replace("c13", "c12").replace("c33", "c11").replace("c66", "c44")
_ORTHORHOMBIC = """c11 c12 c13  0   0   0
                   c12 c22 c23  0   0   0
                   c13 c23 c33  0   0   0
                    0   0   0  c44  0   0
                    0   0   0   0  c55  0
                    0   0   0   0   0  c66"""
_NONE = "0 0 0 0 0 0\n" * 2 + "0 0 0 0 0 0"
_POLAR = """ 0   0   0   0  e15  0
             0   0   0  e15  0   0
            e31 e31 e33  0   0   0"""
# Stiffness and coupling of each class; "-" turns the sign, "2" stands for the factor of a compliance or of d (for a
# stiffness and for e it is 1), c66 is (c11 - c12)/2 where the axis is three- or sixfold.
_CLASSES = {
    "6mm": (_TETRAGONAL, _POLAR),
    "4mm": (_TETRAGONAL, _POLAR),
    "3m": (
        _TRIGONAL,
        """ 0    0   0   0  e15 -2e22
           -e22  e22  0  e15  0    0
            e31  e31 e33  0   0    0""",
    ),
    "32": (
        _TRIGONAL,
        """e11 -e11 0 e14   0    0
            0    0  0  0  -e14 -2e11
            0    0  0  0    0    0""",
    ),
    "mm2": (
        _ORTHORHOMBIC,
        """ 0   0   0   0  e15  0
            0   0   0  e24  0   0
           e31 e32 e33  0   0   0""",
    ),
    "-43m": (
        _CUBIC,
        """0 0 0 e14 0 0
           0 0 0 0 e14 0
           0 0 0 0 0 e14""",
    ),
    "m3m": (_CUBIC, _NONE),
    "-3m": (_TRIGONAL, _NONE),
    "6/mmm": (_TETRAGONAL, _NONE),
    "4/mmm": (_TETRAGONAL, _NONE),
}
CLASSES = tuple(_CLASSES)
TIED_C66 = ("6mm", "3m", "32", "-3m", "6/mmm")  # classes where c66 = (c11 - c12)/2
_PERMITTIVITY = {"-43m": ("eps11",) * 3, "m3m": ("eps11",) * 3, "mm2": ("eps11", "eps22", "eps33")}


def constant_names(crystal_class: str, *, compliant: bool = False) -> tuple[str, ...]:
    """Return the names of a class's independent constants, with s and d in the place of c and e if ``compliant``.

    Examples
    --------
    >>> constant_names("6mm", compliant=True)
    ('s11', 's12', 's13', 's33', 's44', 'd15', 'd31', 'd33', 'eps11', 'eps33')
    """
    choice("crystal_class", crystal_class, CLASSES)
    texts = [each.replace("2c", "c").replace("2e", "e").replace("-", "") for each in _CLASSES[crystal_class]]
    found = {*texts[0].split(), *texts[1].split()} - {"0"} - ({"c66"} if crystal_class in TIED_C66 else set())
    names = (*sorted(found), *sorted(set(_diagonal(crystal_class))))
    return tuple(_compliant(each) for each in names) if compliant else names


def class_tables(
    crystal_class: str, constants: Mapping[str, float], *, compliant: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return stiffness (6, 6), coupling (3, 6) and permittivity (3, 3) of a class, in the units of the constants.

    Parameters
    ----------
    crystal_class : str
        One of `CLASSES`, in the axes of IEEE 176: 3 along the axis of highest order, a mirror of 3m perpendicular to 1,
        a twofold axis of 32 along 1.
    constants : mapping
        By the names of `constant_names`. Non-piezoelectric classes may leave out the permittivity, which is then 1.
    compliant : bool
        True: s, d and eps^T; the first table is then the compliance.
    """
    names = constant_names(crystal_class, compliant=compliant)
    piezoelectric = any(each[0] in "ed" and not each.startswith("eps") for each in names)
    values = {} if piezoelectric else dict.fromkeys(_diagonal(crystal_class), 1.0)
    values |= {each: float(number) for each, number in constants.items()}
    missing, unknown = [each for each in names if each not in values], [each for each in values if each not in names]
    if missing or unknown:
        wrong = f"{', '.join(missing)} missing" if missing else f"{', '.join(unknown)} none of them"
        raise InputError("constants", f"must be {', '.join(names)} of class {crystal_class}, got {wrong}")
    factor = 2.0 if compliant else 1.0
    if compliant:
        values = {_stiff(name): value for name, value in values.items()}
    if crystal_class in TIED_C66:
        values["c66"] = (values["c11"] - values["c12"]) * (2.0 if compliant else 0.5)

    def entry(text: str) -> float:
        name = text.lstrip("-2")
        size = 0.0 if name == "0" else values[name] * (factor if "2" in text.removesuffix(name) else 1.0)
        return -size if text.startswith("-") else size

    stiffness, coupling = (
        np.array([[entry(each) for each in row.split()] for row in text.splitlines()])
        for text in _CLASSES[crystal_class]
    )
    return stiffness, coupling, np.diag([values[each] for each in _diagonal(crystal_class)])


def _diagonal(crystal_class: str) -> tuple[str, ...]:
    return _PERMITTIVITY.get(crystal_class, ("eps11", "eps11", "eps33"))


def _compliant(name: str) -> str:
    return name if name.startswith("eps") else {"c": "s", "e": "d"}[name[0]] + name[1:]


def _stiff(name: str) -> str:
    return name if name.startswith("eps") else {"s": "c", "d": "e"}[name[0]] + name[1:]
