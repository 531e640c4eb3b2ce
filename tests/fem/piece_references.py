"""Stators with a piece, solved by NGSolve alone: what meshed pieces are held against.

PZT-4 Z of 8 x 1.1 mm at 2.17 MHz between free ends unless told otherwise, 2 pairs of 1 mm at 2.2 mm, half metallised,
10 mm aperture.  Written by `python -m tests.validation.ngsolve_pieces` (NGSolve 6.2.2608, Netgen triangles of 0.45 mm,
order 12, 12 hp layers of ratio 0.15; 0.5 mm, 11 and 10 for the five grooves, 10 and 10 for the step).  Order 11, 10
layers and 0.5 mm differ by 7e-7 at most.
"""

import numpy as np

# Y in S; u_x, then u_z in m per V at the places
REFERENCES = {
    # from x = 5.25 to 5.5 mm, 0.15 mm deep
    "groove": (
        8.0143010915e-04 + 3.7637193969e-03j,
        np.array(
            [
                [
                    -3.5695061646e-11 - 2.0963067611e-11j,
                    -3.5169667149e-10 + 4.9090890324e-10j,
                    5.5597389423e-10 - 4.8850754727e-10j,
                ],
                [
                    4.2542882167e-10 - 3.2559679349e-10j,
                    1.2391786757e-10 - 8.0271521483e-11j,
                    -1.6978600362e-10 + 1.4842793886e-10j,
                ],
            ]
        ),
    ),
    # from x = 4.5 + 0.5 k to 4.75 + 0.5 k mm, 0.1 mm deep
    "five grooves": (
        2.1605455085e-04 + 3.8098813766e-03j,
        np.array(
            [
                [
                    -1.1542329896e-10 + 1.6573422277e-11j,
                    -1.2920758288e-10 - 1.9923900551e-11j,
                    -8.5360363446e-11 + 1.9164884549e-11j,
                ],
                [
                    1.4256936005e-10 + 1.3955531874e-11j,
                    1.5564451469e-10 - 1.0873630047e-10j,
                    -2.3222313177e-10 - 8.9696403740e-12j,
                ],
            ]
        ),
    ),
    # of aluminium from x = 5.2 to 5.5 mm, 0.1 mm high, on a floating electrode
    "strip": (
        1.1309010193e-04 + 2.4212485108e-03j,
        np.array(
            [
                [
                    4.7321918962e-11 + 1.3547029379e-11j,
                    9.3273317898e-11 + 1.7896652536e-11j,
                    2.1786110971e-10 + 6.8402749996e-12j,
                ],
                [
                    1.2641682203e-10 - 5.5131581064e-12j,
                    -1.9891860123e-10 - 1.7072875893e-11j,
                    6.3478779444e-11 - 1.6065284566e-11j,
                ],
            ]
        ),
    ),
    # the right end: 8 mm at the bottom, 7.6 mm at the surface
    "bevel": (
        6.0440639508e-04 + 1.0712930774e-03j,
        np.array(
            [
                [
                    1.8198168885e-10 + 5.3580410324e-11j,
                    2.1360669864e-10 + 3.7615207333e-11j,
                    4.3449967588e-10 + 1.1229082459e-10j,
                ],
                [
                    -8.6617257887e-12 - 8.1717035934e-12j,
                    -8.3553109351e-10 - 2.7492480111e-10j,
                    3.5629816373e-10 + 5.5930670691e-11j,
                ],
            ]
        ),
    ),
    # absorbing ends; from x = 5.5 mm on the surface is 0.3 mm lower
    "step": (
        9.9970077207e-04 + 2.9240980333e-03j,
        np.array(
            [
                [
                    9.5730893122e-11 + 1.4503164628e-10j,
                    1.3251253421e-11 + 9.1475909657e-11j,
                    -2.1584221030e-11 - 2.9270116523e-11j,
                ],
                [
                    -1.7263361720e-10 + 1.4045271707e-10j,
                    3.1249327329e-11 - 2.0285267937e-10j,
                    1.3636487723e-12 - 9.3616272522e-11j,
                ],
            ]
        ),
    ),
}


def places(case: str) -> np.ndarray:
    """Where the motion is known, m."""
    return np.array([0.6e-3, 3.9e-3, 7.4e-3 if case == "five grooves" else 6.9e-3])
