"""The parts of numba that are replaced while kernels are compiled: each returns what numba's own returns (oracle)."""

import pytest

from contact.jit.short_pipeline import slow_parts_replaced


@pytest.fixture
def options():
    """Return options of numba: two equal ones, one equal by a default that is set, one other."""
    from numba.core.compiler import Flags

    made = Flags(), Flags(), Flags(), Flags()
    made[0].nrt = made[1].nrt = made[2].nrt = True
    made[2].auto_parallel = Flags().auto_parallel
    made[2].fastmath = Flags().fastmath
    made[3].nrt, made[3].error_model = True, "numpy"
    return made


def test_options_compare_and_hash_as_numbas(options):
    def answers():
        return [[a == b for b in options] for a in options], [hash(each) for each in options]

    own = answers()
    assert own[0][0] == [True, True, True, False]
    with slow_parts_replaced():
        assert answers() == own
        assert options[0] != "nrt"
        for each in options:  # dictionaries keep their entries before and after
            assert {each: 1}[each.copy()] == 1
    assert answers() == own


def test_variables_of_instructions_are_numbas():
    from numba.core.compiler import run_frontend

    def function(a, b):
        total = 0.0
        for k in range(len(a)):
            if a[k] > b:
                total += max(a[k], b) * (1.0, b)[0]
        return total

    def variables():
        return [
            sorted(each.name for each in instruction.list_vars())
            for block in run_frontend(function).blocks.values()
            for instruction in block.body
        ]

    own = variables()
    assert sum(map(len, own)) > 20
    with slow_parts_replaced():
        assert variables() == own
