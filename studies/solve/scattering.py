"""S-parameters of a scene's transducers: what a network analyser would measure between them."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.model.model import Model
from studies.refusal import needed
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value
from studies.solve import passband
from studies.solve.spectrum import converged_admittances, port_admittances

if TYPE_CHECKING:
    import skrf

LOGGER = logging.getLogger(__name__)


def network(
    scene: Scene | str | Path, band: "str | np.ndarray | None" = None, *, z0: str | float = 50.0,
    tolerance: float = 1e-3,
) -> "skrf.Network":  # fmt: skip
    """Return the transducers of a scene as a `skrf.Network`, to be plotted, cascaded and written by scikit-rf.

    Parameters
    ----------
    scene : Scene, path or name of a shipped scene
        Its transducers with two electrodes are the ports, in the same order; drive and terminations are ignored.
    band : str or array, optional
        ``"2.1:2.3:201"`` in MHz, or with units; or frequencies in Hz. By default the driven transducer's passband.
    z0 : str or float
        Reference impedance, ohm.
    tolerance : float
        Of the admittances, over the largest.

    Returns
    -------
    skrf.Network
        ``port_names`` are those of the transducers.

    Raises
    ------
    SceneError
        If the scene has no transducer, or the band cannot be read.
    RunError
        If scikit-rf is not installed, or the tolerance is not met.
    """
    library = needed("skrf", "network")
    model = passband.driven_model(scene)
    reference = reference_impedance(z0)
    at = passband.band_frequencies(model, band)
    names, _, scattering = scattering_matrix(model, at, reference, tolerance)
    result = library.Network(
        frequency=library.Frequency.from_f(at, unit="hz"),
        s=scattering,
        z0=reference,
        name=model.scene.title or "network",
    )
    result.port_names = names
    return result


def scattering_matrix(
    model: Model, at: np.ndarray, reference: float, tolerance: float
) -> tuple[list[str], Any, np.ndarray]:
    """Return the names of the ports, the `fem.PortAdmittance` and S (frequencies, ports, ports) of a resolved scene."""
    ports = port_admittances(model, at, tolerance)
    names, scattering = _in_order(model.scene, ports, reference)
    return names, ports, scattering


def converged_scattering(
    model: Model, at: np.ndarray, reference: float, tolerance: float
) -> tuple[list[str], Any, np.ndarray, tuple[str, ...]]:
    """Return the same as `scattering_matrix` at those frequencies that have an answer, and why others have none."""
    ports, failures = converged_admittances(model, at, tolerance)
    names, scattering = _in_order(model.scene, ports, reference)
    return names, ports, scattering, failures


def _in_order(scene: Scene, ports: Any, reference: float) -> tuple[list[str], np.ndarray]:
    """Return the names of the scene's ports and their S-parameters, both in its order."""
    names = [each.name for each in scene.transducer if each.has_two_electrodes]
    order = [ports.names.index(name) for name in names]
    return names, ports.scattering(reference)[:, order][:, :, order]


def reference_impedance(z0: str | float) -> float:
    """Return a reference impedance in ohm."""
    return Quantity("ohm").read("--z0", toml_value(z0) if isinstance(z0, str) else z0)
