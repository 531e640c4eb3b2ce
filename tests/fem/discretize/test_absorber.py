"""The viscous layer that stands for a half-space where a perfectly matched layer is unstable."""

from fem.discretize.grading import Resolution
from fem.materials.christoffel import stretch_absorbs
from fem.results.solution import solve_driven
from fem.solve.harmonic import motion_difference
from tests.fem.stators import FREQUENCY, comb, cut, plate, wave_of


def test_viscous_layer_converges_with_its_depth():
    """Motion and admittance on 128YX LiNbO3 with 4 elements of loss against 8; half the loss errs by 8e-3."""
    stator = plate(cut("LiNbO3 (Kovacs)", "128YX"), length=9.0, thickness=2.0, bottom="absorbing")
    assert not stretch_absorbs(stator.solid)
    transducer = comb(stator, "a", 2.0, finger_pairs=2)
    place = [0.74 * stator.length]
    near, far = (
        wave_of(
            solve_driven(
                stator,
                (transducer,),
                frequency=FREQUENCY,
                drive="a",
                resolution=Resolution(order=5, edge_layers=0, lossy_elements=count),
            )
        )
        for count in (4, 8)
    )
    assert motion_difference(near.motion(place), far.motion(place)) < 1.2e-3
    assert abs(near.admittance / far.admittance - 1) < 6e-4
