"""Normal force of rough balls against boundary elements: tamaas, a third program beside ours and the oracles.

tamaas solves the contact of heights on a grid with the elastic half-space: every pixel carries what it must, with no
model of asperities. Its approaches are stored (`tests.frozen`); a slow test compares them with the live program. The
approach is that of the undeformed sphere's lowest mean height, from the operator on the tractions, because the solver
shifts the displacement by a constant (findings/tamaas-displacement-offset.sh).
"""

import numpy as np
import pytest

import contact
from studies.lab.afm_patch import AfmPatch, levelled
from tests.frozen import frozen

R, E = 1e-3, 64e9
LOADS = (0.2e-3, 0.87309e-3, 2e-3)  # N
PIXELS, WIDTH = 256, 10.24e-6
PATCH, PIXEL, RMS = 128, 40e-9, 3e-9
SEED = 1


@frozen([(SEED,)])
def patch(seed):
    """Return heights in m of a random surface: power spectrum q^-3.6 between wavelengths of 2 and 0.4 um."""
    random = np.random.default_rng(seed)
    along = 2.0 * np.pi * np.fft.fftfreq(PATCH, PIXEL)
    q = np.hypot(along[:, None], along)
    within = (q > 0.7 * 2.0 * np.pi / 2e-6) & (q < 2.0 * np.pi / 0.4e-6)
    size = np.where(within, np.maximum(q, 2.0 * np.pi / 2e-6) ** -1.8, 0.0)
    heights = np.fft.ifft2(size * np.fft.fft2(random.normal(size=q.shape))).real
    return (RMS * heights / heights.std()).astype(np.float32)


def grid():
    return (np.arange(PIXELS) - PIXELS // 2) * WIDTH / PIXELS


def afm_patch():
    step = (PIXEL, PIXEL)
    return AfmPatch(name="patch", heights=levelled(patch(SEED).astype(float), step), step=step)


def sample(name):
    """Return our asperities of a surface."""
    if name == "patch":
        return afm_patch().asperities(7e-6)
    return contact.Roughness(rms=float(name) * 1e-9).drawn(SEED, 7e-6)


def surface(name):
    """Return the heights of a surface on the grid of tamaas, m."""
    x = grid()
    form = -(x[:, None] ** 2 + x**2) / (2.0 * R)
    if name == "sphere":
        return form
    if name == "patch":  # rows are along y; its middle is the lowest point of the sphere
        assert WIDTH / PIXELS == pytest.approx(PIXEL)
        own = (np.arange(PIXELS) - PIXELS // 2 + PATCH // 2) % PATCH
        return afm_patch().heights[np.ix_(own, own)] + form
    caps = sample(name)
    heights = np.full((PIXELS, PIXELS), -1e-6)
    for x_j, y_j, height, radius in zip(caps.x, caps.y, caps.heights, caps.radius, strict=True):
        top = height - (x_j**2 + y_j**2) / (2.0 * R)
        heights = np.maximum(heights, top - ((x[:, None] - x_j) ** 2 + (x - y_j) ** 2) / (2.0 * radius))
    return heights


@frozen([(name, load) for name in ("sphere", "1", "3", "10", "patch") for load in LOADS])
def approach(name, load):
    """Return the approach in m under a load in N, by tamaas."""
    tamaas = pytest.importorskip("tamaas", reason="tamaas is in the optional extra `peers`")
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.Model(tamaas.model_type.basic_2d, [WIDTH, WIDTH], [PIXELS, PIXELS])
    model.E, model.nu = E, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    heights = surface(name)
    solver = tamaas.PolonskyKeerRey(model, heights, 1e-12)
    solver.setIntegralOperator("dcfft")
    solver.solve(load / WIDTH**2)
    displacement = np.zeros_like(heights)
    model.operators["dcfft"](model.traction, displacement)
    traction = np.asarray(model.traction)
    return np.sum(traction * (displacement - heights)) / np.sum(traction)


# approaches in m by ContactMechanics 1.8.3 (free half-space, hard walls, pentol=1e-13): a second program,
# by another kernel, with the approach counted as that of tamaas
SECOND = {
    "sphere": (1.7643817796813085e-09, 4.712890544298339e-09, 8.189738600619193e-09),
    "3": (2.6028099796073076e-10, 3.841700432015871e-09, 7.989894334102404e-09),
    "patch": (-3.074128370099818e-09, 7.491244601195613e-10, 4.6365105339700304e-09),
}


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("name", list(SECOND))
def test_contact_mechanics_finds_the_approach_of_tamaas(name, load):
    """To 0.01 pm, 1e-4 of the smallest approach."""
    assert float(approach(name, load)) == pytest.approx(SECOND[name][LOADS.index(load)], abs=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SECOND))
def test_contact_mechanics_finds_it_again(name):
    mechanics = pytest.importorskip("ContactMechanics", reason="ContactMechanics is not installed")
    from SurfaceTopography import Topography

    heights = surface(name)
    for load, known in zip(LOADS, SECOND[name], strict=True):
        topography = Topography(heights, physical_sizes=(WIDTH, WIDTH))
        system = mechanics.make_system(surface=topography, substrate="free", young=E)
        system.minimize_proxy(external_force=load, pentol=1e-13)
        force = np.abs(system.substrate.force)[:PIXELS, :PIXELS]
        displacement = np.abs(system.substrate.evaluate_disp(system.substrate.force))[:PIXELS, :PIXELS]
        assert np.sum(force * (displacement - heights)) / np.sum(force) == pytest.approx(known, abs=1e-14)


@pytest.mark.parametrize("load", LOADS)
def test_a_sphere_is_that_of_hertz(load):
    z = float(approach("sphere", load))
    assert 4.0 / 3.0 * E * np.sqrt(R) * z**1.5 == pytest.approx(load, rel=2e-3)


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("name", ["1", "3", "10"])
def test_caps_on_a_ball_carry_what_our_sample_says(name, load):
    """3e-3 with pixels of 40 nm; 5e-4 with 20 nm. Spheres that push each other down as points are no worse."""
    forces = sample(name).forces(R, E, float(approach(name, load)))
    assert float(forces.sum()) == pytest.approx(load, rel=3e-3)


@pytest.mark.parametrize("load", LOADS)
def test_asperities_of_a_patch_carry_up_to_15_per_cent_less_than_its_whole_surface(load):
    """Peaks of pixels stand for it; saddles and what merges carry besides. Nine other patches: 4 to 18 % less."""
    forces = sample("patch").forces(R, E, float(approach("patch", load)))
    assert 0.85 * load < float(forces.sum()) < load


@pytest.mark.parametrize("load", LOADS[1:])
def test_a_mean_field_carries_less_than_samples_at_the_same_approach(load):
    """By 9 and 11 % of the load at 3 nm: its smooth displacement also holds what each asperity makes under itself."""
    rough = contact.Roughness(rms=3e-9)
    z = contact.MeanField(R, E, rough).approach(load)
    carried = [float(rough.drawn(seed, 7e-6).forces(R, E, z).sum()) for seed in range(24)]
    assert 1.03 < np.median(carried) / load < 1.2
