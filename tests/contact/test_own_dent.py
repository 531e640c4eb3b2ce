"""Why a mean field carries less than samples: it counts the disc about each asperity in which no other one stands."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contact import MeanField, Roughness
from contact.law.asperities import Asperities
from contact.law.rough import disc_displacement

R, E = 1e-3, 64e9
RINGS = 80


def without_own_dent(roughness, z, share):
    """Force of rings with p(r) of Greenwood and Tripp, w less a `share` of 2 p d/E; by relaxation."""
    sigma, beta, eta = roughness.rms, roughness.asperity_radius, roughness.density
    reach = math.sqrt(2 * R * (z + 6 * sigma))
    edges = np.linspace(0, reach, RINGS + 1)
    r = 0.5 * (edges[1:] + edges[:-1])
    influence = np.diff(disc_displacement(edges[None, :], r[:, None]), axis=1) / E
    influence -= share * 2 * roughness.spacing / E * np.eye(RINGS)
    d = np.linspace(-z - 40 * sigma, 8 * sigma, 1500)
    heights = np.linspace(-8, 8, 4001)
    density = np.exp(-0.5 * heights**2) / math.sqrt(2 * math.pi) * (heights[1] - heights[0])
    curve = np.array([density @ np.maximum(sigma * heights - each, 0.0) ** 1.5 for each in d])
    curve *= 4 / 3 * E * eta * math.sqrt(beta)
    dent = np.zeros(RINGS)
    for _ in range(400):
        dent += 0.1 * (influence @ np.interp(r**2 / (2 * R) - z + dent, d, curve) - dent)
    p = np.interp(r**2 / (2 * R) - z + dent, d, curve)
    return float(math.pi * np.diff(edges**2) @ p)


def of_samples(roughness, z, number):
    """Mean force of samples at an approach, and its standard deviation."""
    reach = 1.05 * math.sqrt(2 * R * (z + 6 * roughness.rms))
    forces = [float(roughness.drawn(seed, reach).forces(R, E, z).sum()) for seed in range(number)]
    return np.mean(forces), np.std(forces) / math.sqrt(number)


@pytest.mark.slow
@pytest.mark.parametrize(("rms", "load"), [(1e-9, 0.87309e-3), (3e-9, 0.87309e-3), (3e-9, 2.2e-3)])
def test_a_mean_field_without_its_own_disc_carries_what_samples_do(rms, load):
    roughness = Roughness(rms=rms)
    z = MeanField(R, E, roughness).approach(load)
    samples, deviation = of_samples(roughness, z, 24)
    assert without_own_dent(roughness, z, 0.0) == pytest.approx(load, rel=5e-3)  # of 80 rings
    assert 0.05 < samples / load - 1.0 < 0.16
    assert abs(without_own_dent(roughness, z, 1.0) - samples) < 1.5 * deviation + 5e-3 * load


def test_the_disc_about_an_asperity_displaces_its_middle():
    """2 p d/E, by the sum of point forces; and no asperity of a sample stands in it."""
    d = 0.4e-6
    summed = quad(lambda r: 2 * math.pi * r / (math.pi * E * r), 0.0, d)[0]
    assert summed == pytest.approx(2 * d / E, rel=1e-12)
    assert float(disc_displacement(d, 0.0)) / E == pytest.approx(summed, rel=1e-12)
    roughness = Roughness(rms=3e-9)
    sample: Asperities = roughness.drawn(1, 6e-6)
    assert float(np.min(sample.nearest)) >= roughness.spacing * (1.0 - 1e-12)
