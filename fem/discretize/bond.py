"""An elastic bond between two layers: an element whose two faces move apart by the traction over a stiffness per area.

Between the displacements below and above stand springs of stiffness K per area; the potential is continuous. The
element has unknowns on its two faces alone: its one-dimensional stiffness couples its first and last node, and its
nodes between are held by the identity. Without mass and without terms along x it is exact whatever its height.
"""

from dataclasses import fields as dataclass_fields

import numpy as np

from fem.discretize.graded_medium import OwnLineMedium
from fem.discretize.spectral import LineMatrices
from fem.geometry import Bond
from fem.materials.medium import Medium

HEIGHT = 1e-9  # of the element, length units; the matrices do not depend on it
# Permittivity per height of the element, in the scaled units of the form: the potential then jumps by 1e-6 of what it
# does across the layers; ten times as much costs a digit of the solution by rounding
PERMITTANCE = 1e6


def bond_medium(bond: Bond, body: Medium, order: int, length_unit: float) -> OwnLineMedium:
    """Return the medium of a bond's element.

    Parameters
    ----------
    bond : Bond
    body : Medium
        Of the layer above it, for the units and the fields.
    order : int
        Of the elements.
    length_unit : float
        m.
    """
    law = np.zeros((9, 9))
    normal, tangential = (each * length_unit / body.stress_unit for each in (bond.normal, bond.tangential))
    law[2, 2], law[3, 3], law[4, 4], law[8, 8] = normal, tangential, tangential, -PERMITTANCE
    stiffness = np.eye(order + 1)
    stiffness[np.ix_([0, order], [0, order])] = [[1.0, -1.0], [-1.0, 1.0]]
    nothing = np.zeros((order + 1, order + 1))
    own = {each.name: getattr(body, each.name) for each in dataclass_fields(Medium)}
    own |= {"law": law * HEIGHT, "inertia": np.zeros(len(body.fields))}
    line = LineMatrices(mass=nothing, stiffness=stiffness, advection=nothing)
    return OwnLineMedium(**own, line=line, inner_nodes=False)
