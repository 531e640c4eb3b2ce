"""The stored answers of oracles are those of the live oracles (see `frozen`)."""

import numpy as np
import pytest

from tests.frozen import MODULES, SAME, stored_in


@pytest.mark.slow
@pytest.mark.parametrize("module", MODULES)
def test_stored_answers_are_those_of_the_live_oracle(module):
    functions = stored_in(module)
    assert functions
    for each in functions:
        assert set(np.load(each.file)) == {repr(case) for case in each.cases}
        for case in each.cases:
            live = np.asarray(each.live(*case))
            np.testing.assert_allclose(each(*case), live, rtol=SAME, atol=1e-12 * abs(live).max(), err_msg=repr(case))
