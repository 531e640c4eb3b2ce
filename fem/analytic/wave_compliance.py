r"""Excitation of the surface wave by tractions: the residue Gamma of the surface's compliance at the Rayleigh pole.

A traction t exp(i(omega t - k x)) moves the surface by u = Z(omega/k)^-1 t/k with the surface impedance Z of `stroh`.
At the Rayleigh velocity v_R an eigenvalue lambda(v) of Z, with unit eigenvector m, vanishes. Near it, at fixed
frequency,

    u_z = |m_z|^2 t_z / (k lambda' (v - v_R)) = Gamma t_z/(k - k_R),    Gamma = -|m_z|^2 / (lambda'(v_R) v_R),    (1)

because v - v_R = -v_R (k - k_R)/k. Gamma in 1/Pa does not depend on the frequency. The power of the wave per width is
|u_z|^2 omega/(4 Gamma). The corresponding residue for u_x and a tangential traction is r^2 Gamma, r = |u_x/u_z|.
Compare Auld, *Acoustic Fields and Waves in Solids* II (1973), sections 10 and 12.
"""

import numpy as np

from fem.analytic.half_space import BELOW_LIMIT, falling_root, rayleigh, surface_impedance
from fem.analytic.layered import LayeredImpedance
from fem.analytic.layered_wave import bound_wave
from fem.geometry import Stator
from fem.materials import Solid
from fem.parameters import InputError, positive

# Step of the angle in the five-point derivative, which is accurate to 1e-11: steps of half and twice the size agree.
STEP = 1e-4


def wave_compliance(solid: Solid, surface: str = "vacuum") -> float:
    """Return Gamma, equation (1), of a half-space's Rayleigh wave in 1/Pa.

    Parameters
    ----------
    solid : Solid
        In the frame x along the propagation, z out of the surface; its losses are ignored.
    surface : str
        Electrical condition, as in `rayleigh`.

    Raises
    ------
    InputError
        For an unknown surface.
    ConvergenceError
        If the cut has no subsonic wave.

    Examples
    --------
    >>> import fem
    >>> print(f"{fem.wave_compliance(fem.material('PZT-8')):.4e}")
    4.8674e-12
    """
    impedance, limit = surface_impedance(solid, surface)
    velocity = rayleigh(solid, surface).velocity / impedance.velocity_unit
    index = int(np.argmin(np.abs(impedance.eigenvalues(velocity))))
    # lambda is analytic in the angle with v = limit sin(angle), up to the limiting velocity
    angle = np.arcsin(velocity / limit)
    step = STEP * min(1.0, 10.0 * (np.pi / 2 - angle))
    values = [impedance.eigenvalues(limit * np.sin(angle + n * step))[index] for n in (-2, -1, 1, 2)]
    slope = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step) / (limit * np.cos(angle))
    amplitude = impedance.mode(velocity, index)[impedance.displaced]
    share = abs(amplitude[-1]) ** 2 / float(np.sum(np.abs(amplitude) ** 2))
    return float(-share / (slope * velocity) / impedance.stress_unit)


def bound_compliance(stator: Stator, frequency: float) -> float:
    """Return Gamma, equation (1), in 1/Pa of the wave that a stator guides at its surface at a frequency in Hz.

    Without layers it is that of `wave_compliance`. With layers the thicknesses over the wavelength change with v, so
    that lambda is differentiated at the fixed frequency.
    """
    if not stator.layers:
        return wave_compliance(stator.solid, stator.bare_surface)
    wave = bound_wave(stator, frequency)
    impedance = LayeredImpedance(stator.solid, stator.layers, frequency=frequency)

    def eigenpairs(velocity: float) -> tuple[np.ndarray, np.ndarray]:
        top = impedance.stack(np.array([velocity])).impedance
        return np.linalg.eigh(impedance.mechanical(top, surface=stator.bare_surface)[0])

    values, vectors = eigenpairs(wave.velocity)
    index = int(np.argmin(abs(values)))
    step = STEP * min(1.0, 10.0 * (impedance.limit / wave.velocity - 1.0))
    near = [eigenpairs(wave.velocity * (1.0 + n * step))[0][index] for n in (-2, -1, 1, 2)]
    slope = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)  # times the velocity
    return float(-(abs(vectors[-1, index]) ** 2) / slope / impedance.scales[0])


def travelling_compliance(solid: Solid, velocity: float) -> np.ndarray:
    """Return Z^-1 of a half-space, 1/Pa: u = Z^-1 t/k under a traction t exp(i k (v t - x)).

    Parameters
    ----------
    solid : Solid
        In the frame x along the propagation, z out of the surface; its losses are ignored.
    velocity : float
        v, m/s.

    Returns
    -------
    ndarray, shape (2, 2), complex
        Of u_x and u_z under t_x and t_z.

    Raises
    ------
    InputError
        If v is not below the limiting velocity of the bulk waves.

    Examples
    --------
    At rest it is 2 (1 - nu^2)/E for a normal traction:

    >>> import fem
    >>> steel = fem.isotropic(name="steel", youngs_modulus=200e9, poisson_ratio=0.3, density=7850.0)
    >>> print(f"{fem.travelling_compliance(steel, 1.0)[1, 1].real:.4e} {2 * (1 - 0.3**2) / 200e9:.4e}")
    9.1000e-12 9.1000e-12
    """
    positive("velocity", velocity, "m/s")
    impedance, limit = surface_impedance(solid, "vacuum")
    if velocity >= limit * impedance.velocity_unit:
        rule = f"must be below that of the bulk waves, {limit * impedance.velocity_unit:.6g} m/s"
        raise InputError("velocity", rule, velocity, "m/s")
    stiff = impedance.stiff(velocity / impedance.velocity_unit)
    compliance = np.linalg.inv(stiff) / impedance.stress_unit
    return compliance[np.ix_((0, -1), (0, -1))]


def spring_shift(
    solid: Solid, normal: float, tangential: float, frequency: float, surface: str = "vacuum"
) -> float | None:
    """Return (k - k_R)/k_R of a Rayleigh wave on a surface that springs connect to a plane at rest.

    The springs exert the tractions -K_n u_z and -K_t u_x, so that det(k Z(omega/k) + diag(K_t, 0, K_n)) = 0, which is
    solved without approximation. For an isotropic solid and K_t = 0 this is mu R(k) = K k_T^2 q_L (Boechler et al., PRL
    111, 036103 (2013)). To first order the shift is -Gamma (K_n + r^2 K_t)/k.

    Parameters
    ----------
    solid : Solid
        As in `wave_compliance`.
    normal, tangential : float
        K_n and K_t, Pa/m.
    frequency : float
        Hz.
    surface : str
        Electrical condition, as in `rayleigh`.

    Returns
    -------
    float or None
        None if the wave would be faster than a bulk wave, so that it leaks.

    Examples
    --------
    >>> import fem
    >>> cut = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    >>> print(f"{fem.spring_shift(cut, 1e13, 0.844e13, 9.61e6):.4e}")
    -2.7419e-03
    """
    positive("frequency", frequency, "Hz")
    for name, stiffness in (("normal", normal), ("tangential", tangential)):
        if not np.isfinite(stiffness):
            raise InputError(name, "must be a finite stiffness", stiffness, "Pa/m")
    velocity = rayleigh(solid, surface).velocity
    impedance, limit = surface_impedance(solid, surface)
    unit = impedance.velocity_unit
    springs = np.zeros(int(impedance.displaced.sum()))
    springs[[0, -1]] = tangential / impedance.stress_unit, normal / impedance.stress_unit

    def sprung(scaled: float) -> np.ndarray:
        return impedance.stiff(scaled) + np.diag(springs * scaled * unit / (2.0 * np.pi * frequency))

    def lowest(scaled: float) -> float:
        return float(np.linalg.eigvalsh(sprung(scaled))[0])

    top = limit * (1.0 - BELOW_LIMIT)
    if lowest(top) > 0.0:
        return None
    root = falling_root(lowest, top)
    moved = np.abs(np.linalg.eigh(sprung(root))[1][:, 0]) ** 2
    if moved[0] + moved[-1] < 0.1:  # a shear-horizontal wave, on which springs along x and z hardly act
        return None
    return float(velocity / unit / root - 1.0)


def film_shift(stator: Stator, film: Solid, thickness: float, frequency: float) -> float:
    r"""Return dv/v of the wave that a stator guides, to first order in a thin film on its surface.

    With u = (u_x, u_y, u_z) at the surface, u_z = 1, and M the stiffness of the film in its plane (no traction on its
    faces; M = c11 - c13^2/c33 along x in an isotropic one),

        dv/v = Gamma k h (u_t^* M u_t - rho v^2 |u|^2),    u_t = (u_x, u_y)

    (Auld, *Acoustic Fields and Waves in Solids* II (1973), chapter 12). The film's piezoelectricity is left out. Films
    that are much stiffer than the stator change v by up to 5 % less or more than this, and where the terms cancel by
    20 % (SiO2 on 128YX lithium niobate); below layers the tractions are left out, 7 % below 0.05 wavelengths.
    `layered_waves` has the whole answer.

    Parameters
    ----------
    stator : Stator
        Without the film.
    film : Solid
        In the stator's frame.
    thickness : float
        m.
    frequency : float
        Hz.

    Examples
    --------
    >>> import fem
    >>> cut = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    >>> chip = fem.Stator(solid=cut, length=0.03, thickness=float("inf"), ends="absorbing", above="vacuum")
    >>> print(f"{fem.film_shift(chip, fem.material('AlN'), 1e-6, 9.6e6):.1e}")
    5.8e-03
    """
    positive("thickness", thickness, "m")
    wave = bound_wave(stator, frequency)
    plane, across = [0, 5], [2, 3, 4]  # strains of the film's plane with d/dy = 0, and those without stress
    c = film.stiffness
    membrane = c[np.ix_(plane, plane)] - c[np.ix_(plane, across)] @ np.linalg.solve(
        c[np.ix_(across, across)], c[np.ix_(across, plane)]
    )
    u = wave.displacement
    if stator.plane:
        depth = sum(each.thickness or 0.0 for each in stator.layers[-stator.plane :]) * frequency / wave.velocity
        u = wave.profile(depth)[0][0]
    stiff = (u[:2].conj() @ membrane @ u[:2]).real
    inert = film.density * wave.velocity**2 * float(np.sum(abs(u) ** 2))
    k_h = 2.0 * np.pi * frequency / wave.velocity * thickness
    return float(bound_compliance(stator, frequency) * k_h * (stiff - inert))
