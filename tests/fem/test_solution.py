"""The driven stator on one discretisation: against the sparse direct solve, and by reciprocity, symmetry and power."""

from dataclasses import replace

import numpy as np
import pytest

from fem.circuit import Drive
from fem.discretize.element_sizes import Resolution
from fem.materials import VACUUM_PERMITTIVITY
from fem.materials.christoffel import slowest_wavelength
from fem.results.power_balance import power_balance
from tests.fem.direct import direct_solution
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of

GENERAL = (17.0, 31.0, 49.0)


@pytest.mark.parametrize(
    ("solid", "rest", "layers"),
    [
        pytest.param(cut("PZT-8", "Z"), {"ends": "free"}, 1, marks=pytest.mark.slow),
        pytest.param(cut("PZT-8", "X"), {"ends": "absorbing", "bottom": "grounded"}, 0, marks=pytest.mark.slow),
        (lossless("LiNbO3 (Kovacs)", "128YX"), {"ends": "absorbing"}, 0),
        pytest.param(
            lossless("LiNbO3 (Warner)", "YZ"), {"ends": "clamped", "bottom": "clamped"}, 0, marks=pytest.mark.slow
        ),
        (cut("LiNbO3 (Ogi)", GENERAL, quality=300.0), {"ends": "free", "bottom": "grounded"}, 0),
    ],
    ids=["PZT free", "X-poled grounded", "128YX absorbing", "YZ clamped", "general free"],
)
def test_structured_and_direct_solve_agree(solid, rest, layers):
    """Two different transducers.  What differs is the direct mesh along the stretches: 1e-6 of the field there."""
    order = 7 - layers
    stator = plate(solid, length=3.2, thickness=0.4, **rest)
    pair = comb(stator, "a", 0.9), comb(stator, "b", 2.4, period=0.8, metallisation=0.4)
    ours = solution(stator, pair, order=order, layers=layers)
    direct = direct_solution(
        stator,
        pair,
        frequency=FREQUENCY,
        resolution=Resolution(order=order, edge_layers=layers),
        wavelength=slowest_wavelength(solid, FREQUENCY),
        segment_size=0.25,
        segment_layers=1,
    )
    own = ours.fields.admittances
    assert ours.fields.names == direct.names
    assert np.abs(own - direct.admittances).max() < 1e-9 * np.abs(own).max()
    x = np.linspace(1e-3, 1 - 1e-3, 61) * stator.length
    moved, reference = wave_of(ours).motion(x), direct.surface(x) @ ours.circuit.voltages
    difference = np.abs(moved - reference).max(axis=0) / np.abs(reference).max()
    covered = np.array([np.any([(abs(x_ - t.center) < 0.35 * t.period) for t in pair]) for x_ in x])
    assert difference.max() < 1e-5
    clamped_corners = stator.ends == "clamped"  # singular: they converge slowly along x in the direct mesh
    assert difference[covered].max() < (1e-7 if clamped_corners else 5e-9)


STATORS = (
    (cut("PZT-8", "Z"), {"ends": "free"}),
    (cut("PZT-5H", "X"), {"ends": "absorbing", "bottom": "grounded"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {"ends": "absorbing", "bottom": "clamped"}),
    (lossless("LiNbO3 (Kovacs)", "128YX"), {"ends": "clamped"}),
    (cut("LiNbO3 (Ogi)", GENERAL, quality=300.0), {"ends": "free", "bottom": "clamped"}),
    (cut("PZT-4", "Z"), {"ends": "absorbing", "bottom": "grounded", "above": "vacuum"}),
)
NAMES = [f"{solid.name} {solid.frame} {rest['ends']}" for solid, rest in STATORS]


@pytest.fixture(scope="module", params=STATORS, ids=NAMES)
def three(request):
    """Three transducers, no two alike, driven at the left one."""
    solid, rest = request.param
    stator = plate(solid, length=9.0, **rest)
    row = (
        comb(stator, "a", 1.7, finger_pairs=2),
        comb(stator, "b", 4.6, period=0.9, metallisation=0.3, termination="short"),
        comb(stator, "c", 7.4, period=1.1, metallisation=0.7, termination=50.0 - 20.0j),
    )
    return solution(stator, row)


def test_the_port_matrix_is_symmetric_whatever_the_modes_err_by():
    """The eigensolver gives the modes' shapes to 1e-11; errors of 1e-5 change the transfer, not its symmetry."""
    stator = plate(cut("PZT-8", "Z"), length=5.5)
    row = (comb(stator, "a", 1.5), comb(stator, "b", 4.0, period=0.9, metallisation=0.4, finger_pairs=2))
    network = solution(stator, row).fields.network
    exact, size = network.modes, network.modes.section.size
    mirror = np.where(exact.section.odd, -1.0, 1.0)[:, None]
    right = exact.right @ (np.eye(size) + 1e-5 * np.random.default_rng(3).standard_normal((size, size)))
    modes = replace(exact, right=right, left=mirror * right)
    for name in ("right_impedance", "left_impedance"):
        modes.__dict__[name] = getattr(exact, name)
    scatterers = tuple(replace(each, modes=modes) for each in network.scatterers)
    charges = replace(network, modes=modes, scatterers=scatterers).solve().reactions
    assert abs(charges[0, 1] / network.solve().reactions[0, 1] - 1) > 1e-8
    assert charges[0, 1] == pytest.approx(charges[1, 0], rel=1e-11)


def test_reciprocity(three):
    y = three.fields.admittances
    assert np.abs(y - y.T).max() < 1e-11 * np.abs(y - np.diag(np.diag(y))).max()


TWO_ROWS = (
    (cut("PZT-8", "Z"), {"bottom": "grounded", "ends": "free"}),
    (cut("PZT-8", "Z"), {"bottom": "free"}),
    (cut("PZT-8", "Z"), {"bottom": "absorbing"}),
    pytest.param(cut("LiNbO3 (Kovacs)", "128YX"), {"bottom": "absorbing"}, marks=pytest.mark.slow),
)


@pytest.mark.parametrize(("solid", "rest"), TWO_ROWS)
def test_two_runs_are_reciprocal(solid, rest):
    """Current into b, shorted, per volt at a = current into a, shorted, per volt at b: one definition of a port.

    The transducer with a finger left out would carry a net charge if its mean potential were held.
    """
    stator = plate(solid, length=8.0, **rest)
    a = comb(stator, "a", 2.0, finger_pairs=2, pattern="+-+0", termination="short")
    b = comb(stator, "b", 5.7, finger_pairs=2, termination="short")
    forward, backward = (solution(stator, (a, b), drive=name) for name in "ab")
    transfer, reverse = forward.circuit.currents[1], backward.circuit.currents[0]
    assert transfer == pytest.approx(reverse, rel=1e-11)
    for index, scatterer in enumerate(forward.fields.network.scatterers):
        reactions = scatterer.piece.matrix[-2:] @ forward.sides(index)
        assert abs(reactions.sum()) < 1e-11 * abs(reactions).max()


def test_passive(three):
    """No combination of voltages draws power out of the stator."""
    dissipated = np.linalg.eigvalsh((three.fields.admittances + three.fields.admittances.conj().T).real / 2)
    assert dissipated[0] > -1e-11 * np.abs(three.fields.admittances).max()
    if three.fields.stator.ends == "absorbing" or three.fields.stator.solid.is_lossy:
        assert dissipated[-1] > 1e-4 * np.abs(three.fields.admittances).max()


def test_power_goes_where_the_audit_says(three):
    """Power in at the combs = flux through the lines + loss between them, each from other matrices."""
    powers = power_balance(three)
    assert powers.input > 0
    assert powers.residual < 1e-6


def test_order_of_the_list_does_not_matter(three):
    turned = solution(three.fields.stator, three.fields.transducers[::-1])
    assert turned.circuit.admittance == three.circuit.admittance


@pytest.mark.parametrize(("name", "orientation"), [("PZT-8", "Z"), ("PZT-8", "X"), ("LiNbO3 (Kovacs)", "128YX")])
@pytest.mark.parametrize("ends", ["free", "absorbing"])
def test_left_and_right_are_mirror_images(name, orientation, ends):
    """Equal transducers, the one driven and then the other: |u| at x and at length - x."""
    stator = plate(cut(name, orientation), length=8.0, ends=ends)
    pair = comb(stator, "a", 1.6, finger_pairs=2), comb(stator, "b", 6.4, finger_pairs=2)
    x = np.linspace(0.01, 0.99, 37) * stator.length
    one, other = (
        wave_of(solution(stator, pair, drive=name_)).motion(places)
        for name_, places in (("a", x), ("b", stator.length - x))
    )
    assert np.abs(abs(one) - abs(other)).max() < 1e-9 * abs(one).max()
    sign = one[1, 0] / other[1, 0]
    assert np.abs(one - sign * np.array([[-1.0], [1.0]]) * other).max() < 1e-9 * abs(one).max()


def test_terminations_in_the_field():
    """A huge impedance is open, none is short; both move the motion of the driven one's field."""
    solid = cut("PZT-8", "Z")
    stator = plate(solid, length=8.0)
    x = np.linspace(0.02, 0.98, 25) * stator.length
    motion = {}
    for termination in ("open", "short", 1e13, 0.0, 200.0):
        pair = comb(stator, "a", 1.6), comb(stator, "b", 5.4, finger_pairs=2, termination=termination)
        motion[termination] = wave_of(solution(stator, pair)).motion(x)
    size = np.abs(motion["open"]).max()
    assert np.abs(motion["open"] - motion[1e13]).max() < 1e-8 * size
    assert np.abs(motion["short"] - motion[0.0]).max() == 0
    assert np.abs(motion["short"] - motion["open"]).max() > 1e-2 * size
    assert np.abs(motion[200.0] - motion["open"]).max() > 1e-3 * size


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_closed_lossless_stator_takes_no_power(ends):
    """No loss and no open end: Re Y = 0 to the rounding of |Y|."""
    stator = plate(lossless("PZT-8", "Z"), length=5.0, ends=ends)
    y = solution(stator, (comb(stator, "a", 1.6), comb(stator, "b", 3.6))).fields.admittances
    assert np.abs(y.real).max() < 1e-9 * np.abs(y).max()


@pytest.mark.parametrize(
    ("solid", "rest"),
    [
        (lossless("PZT-8", "Z"), {}),
        (lossless("LiNbO3 (Warner)", "YZ"), {"bottom": "grounded"}),
        (lossless("quartz (Bechmann)", "ST-X"), {"bottom": "clamped"}),
        (lossless("LiNbO3 (Ogi)", GENERAL), {}),
    ],
    ids=["PZT", "YZ", "ST-X", "general"],
)
def test_lossless_power_leaves_through_the_ends(solid, rest):
    """Electrical power in = mechanical power out through two lines, and what a resistor takes."""
    stator = plate(solid, length=7.0, **rest)
    ohm = 75.0 + 30.0j
    pair = comb(stator, "a", 1.6, finger_pairs=2), comb(stator, "b", 5.1, termination=ohm)
    solved = solution(stator, pair, drive=Drive(sources={"a": 1.0}, impedance=20.0))
    powers = power_balance(solved)
    port = 1
    load = 0.5 * ohm.real * abs(solved.circuit.currents[port]) ** 2
    assert powers.radiated + load == pytest.approx(powers.input, rel=1e-9)
    assert powers.residual < 1e-9


@pytest.mark.parametrize(
    ("solid", "rest"),
    [
        (lossless("PZT-8", "Z"), {}),
        (lossless("LiNbO3 (Warner)", "YZ"), {}),
        (cut("LiNbO3 (Kovacs)", "128YX"), {"thickness": np.inf}),
        (cut("LiNbO3 (Ogi)", GENERAL), {}),
    ],
    ids=["PZT", "YZ", "128YX half-space", "general"],
)
def test_absorbing_ends_send_no_surface_wave_back(solid, rest):
    """Right of the transducer: amplitudes of the modes going left, found from the lines and their fluxes alone."""
    stator = plate(solid, length=7.0, **rest)
    solved = solution(stator, (comb(stator, "a", 1.6, finger_pairs=2),))
    modes, n = solved.fields.modes, solved.fields.section.size
    line = solved.sides(0)[n : 2 * n]
    block = solved.fields.network.scatterers[0].piece
    flux = block.matrix[n : 2 * n] @ solved.sides(0)
    both = np.block([[modes.right, modes.left], [modes.right_flux, modes.left_flux]])
    travels = np.abs(modes.wavenumbers.imag) < 0.05 * np.abs(modes.wavenumbers.real)
    constant = modes.wavenumbers == 0  # right and left alike: one column of the two
    keep = np.append(np.ones(n, dtype=bool), ~constant)
    amplitudes = np.linalg.lstsq(both[:, keep], np.concatenate([line, flux]), rcond=None)[0]
    right, left = amplitudes[:n], np.zeros(n, dtype=complex)
    left[~constant] = amplitudes[n:]
    assert np.abs(right[travels]).max() > 0
    assert np.abs(left[travels]).max() < 1e-9 * np.abs(right[travels]).max()


def test_capacitance_at_low_frequency():
    """Im Y / omega does not depend on the frequency, and its real part is the loss tangent's."""
    solid = cut("PZT-8", "Z", quality=np.inf, loss=0.004)
    stator = plate(solid, length=12.0, thickness=4.0)
    transducer = comb(stator, "a", 6.0, finger_pairs=3)
    found = []
    for frequency in (FREQUENCY * 1e-3, FREQUENCY * 2e-3):
        y = solution(stator, (transducer,), frequency=frequency, order=8, layers=2).circuit.admittance
        found.append(y / (2j * np.pi * frequency))
    assert found[0].real == pytest.approx(found[1].real, rel=1e-3)
    assert 0 < -found[0].imag / found[0].real < 0.0041
    assert 1e-11 < found[0].real < 1e-9


def test_vacuum_adds_its_capacitance():
    """Half-metallised fingers have eps per period and aperture, K(k)/K(k') = 1 (Engan 1969): vacuum adds eps_0.

    One period more of a long transducer; 5 periods already see the stator's bottom, 1.5 below, to 1e-3.
    """
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    slow = 1e-2 * FREQUENCY
    each = []
    for above in ("none", "vacuum"):
        stator = plate(solid, length=16.0, thickness=1.5, above=above)
        found = [
            solution(
                stator, (comb(stator, "a", 8.0, finger_pairs=pairs),), frequency=slow, order=6, layers=1
            ).circuit.admittance
            for pairs in (5, 6)
        ]
        each.append((found[1] - found[0]).imag / (2 * np.pi * slow * 0.02))
    assert each[1] - each[0] == pytest.approx(VACUUM_PERMITTIVITY, rel=2e-3)
    assert each[0] / VACUUM_PERMITTIVITY == pytest.approx(55, rel=0.03)  # eps_p^T of 128YX, Campbell 1998


def test_transducers_near_ends_and_each_other():
    """Outer gaps smaller than half a gap: the same stator seen from its mirror image."""
    solid = cut("PZT-8", "Z")
    stator = plate(solid, length=4.0, ends="free")
    near = comb(stator, "a", 0.0)
    left = replace(near, center=near.center - near.extent[0] + 0.03 * near.period)
    right = replace(left, name="b", center=left.center + left.extent[1] - left.extent[0] + 0.04 * left.period)
    one = solution(stator, (left, right), order=7)
    turned = tuple(replace(each, center=stator.length - each.center) for each in (left, right))
    other = solution(stator, turned, order=7)
    y, back = one.fields.admittances, other.fields.admittances[::-1, ::-1]
    assert np.abs(y - back).max() < 1e-9 * np.abs(y).max()
    moved = solution(stator, (replace(left, center=left.center + 0.2 * near.period),), order=7)
    assert abs(moved.circuit.admittance / y[0, 0] - 1) > 1e-3


UNEQUAL = (
    (cut("PZT-8", "Z", quality=200.0), {"bottom": "grounded", "ends": "free"}),
    (cut("LiNbO3 (Kovacs)", "128YX", quality=400.0), {"thickness": np.inf}),
    (lossless("PZT-8", "Z"), {}),
)


def unequal(solid, rest, apertures, *, mirrored=False, layers=0):
    """Three transducers with these apertures, solved; ``mirrored``: on the mirrored stator, named as before."""
    stator = plate(solid, length=9.0, **({"thickness": 0.8} | rest))
    row = tuple(
        comb(stator, name, 9.0 - at if mirrored else at, aperture=aperture, **given)
        for name, at, aperture, given in zip(
            "abc", (1.6, 4.4, 7.2), apertures, ({"finger_pairs": 2}, {"termination": 75.0 + 30.0j}, {}), strict=True
        )
    )
    drive = Drive(sources={"a": 1.0, "c": 0.5j}, impedance=20.0)
    return solution(stator, row if not mirrored else row[::-1], drive=drive, layers=layers)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("apertures", [(20e-3, 10e-3, 15e-3), (10e-3, 20e-3, 10e-3), (4e-3, 74e-3, 5e-3)])
@pytest.mark.parametrize(("solid", "rest"), UNEQUAL, ids=["grounded", "half-space", "lossless"])
def test_power_balances_with_unequal_apertures(solid, rest, apertures, mirrored):
    """The load's power is its resistance times its current; what no load takes and no end radiates is lost."""
    found = unequal(solid, rest, apertures, mirrored=mirrored)
    powers, circuit = power_balance(found), found.circuit
    load = 0.5 * 75.0 * abs(circuit.currents[circuit.names.index("b")]) ** 2
    assert powers.loads == pytest.approx(load, rel=1e-9, abs=0)
    assert powers.input == pytest.approx(circuit.power, rel=1e-12)
    assert powers.solid + powers.loads + powers.radiated == pytest.approx(powers.input, rel=1e-9)
    assert powers.residual < 1e-9
    if not solid.is_lossy:
        assert abs(powers.solid) < 1e-9 * powers.input
    other = power_balance(unequal(solid, rest, apertures, mirrored=not mirrored))
    if rest == {"bottom": "grounded", "ends": "free"} or not solid.is_lossy:  # x -> -x is a symmetry of poled ceramics
        assert (powers.left, powers.right) == pytest.approx((other.right, other.left), rel=1e-9, abs=1e-12 * load)


def test_the_residual_sees_the_whole(three):
    """A source whose current is not that of the fields gives more than they carry, and the residual says it."""
    currents = three.circuit.currents.copy()
    currents[three.circuit.sources[0]] *= 1.1
    off = replace(three, circuit=replace(three.circuit, currents=currents))
    powers = power_balance(off)
    assert powers.residual > 0.05 * powers.input / off.circuit.apparent_power


@pytest.mark.parametrize(("solid", "rest"), UNEQUAL[:2], ids=["grounded", "half-space"])
def test_each_strip_along_y_is_neutral(solid, rest):
    """Over a ground: the admittance between two transducers is that per metre times the narrower aperture."""
    equal = unequal(solid, rest, (10e-3,) * 3).fields.admittances
    for apertures in ((10e-3, 20e-3, 10e-3), (10e-3, 74e-3, 5.3e-3)):
        widths = np.minimum.outer(apertures, apertures) / 10e-3
        found = unequal(solid, rest, apertures).fields
        assert abs(found.admittances / widths - equal).max() < 1e-12 * abs(equal).max()
        assert abs(found.admittances[0, 1] / equal[0, 1] - 1) < 1e-9
