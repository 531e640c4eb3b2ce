"""Shapes of a kernel's arrays: what does not fit is refused with names and numbers."""

from collections import namedtuple

import numpy as np
import pytest

from contact.jit.array_shapes import check_shapes

Problem = namedtuple("Problem", "parameters paths")
Paths = namedtuple("Paths", "height")
DECLARED = {"problem.paths.height": "n", "state": "3+n", "sums": "2 | 2+4k", "fast": "8 k"}


def given(**changed):
    arrays = {
        "problem": Problem(np.zeros(11), Paths(np.zeros(2))), "state": np.zeros(5), "sums": np.zeros(14),
        "fast": np.zeros((8, 3)),
    }  # fmt: skip
    return arrays | changed


def test_shapes_that_belong_together_pass():
    check_shapes("kernel", DECLARED, given())
    check_shapes("kernel", DECLARED, given(sums=np.zeros(2), fast=np.zeros((8, 1))))
    check_shapes("kernel", DECLARED, given(problem=None))


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"state": np.zeros(4)}, r"state has the shape \(4,\), but \(3\+n\) is expected with n = 2"),
        ({"fast": np.zeros((8, 4))}, r"fast has the shape \(8, 4\), but \(8 k\) is expected with n = 2, k = 3"),
        ({"sums": np.zeros(15)}, r"sums has the shape \(15,\), but \(2 \| 2\+4k\) is expected"),
        ({"problem": Problem(None, Paths(np.zeros((2, 3))))}, r"problem.paths.height has the shape \(2, 3\)"),
        ({"state": np.zeros((5, 1))}, "state has the shape"),
        ({"state": np.zeros(2)}, "state has the shape"),
    ],
)
def test_a_shape_that_does_not_fit_is_refused(changed, sentence):
    with pytest.raises(ValueError, match=sentence):
        check_shapes("kernel", DECLARED, given(**changed))


def test_a_motion_without_its_deformations_is_refused_before_the_kernel_reads_beyond():
    from contact.answers.rest_motion import rest, rest_problem
    from contact.events import event_driven
    from tests.contact.motors import orbit, slider

    if not hasattr(event_driven.travel, "shapes"):
        pytest.skip("plain Python looks at every index itself")
    motion = rest(slider(), (orbit(3e-9),), rest_problem(slider(), (orbit(3e-9),)), nodes=8, truncation=1e-5)
    motion.carried = motion.carried._replace(deformation=np.empty(0))
    with pytest.raises(
        ValueError, match=r"travel: state.deformation has the shape \(0,\), but \(n\) is expected with .*n = 1"
    ):
        motion.turn(1)
