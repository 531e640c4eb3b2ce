"""Every kernel of the package must compile by the project's own way: the fallback gives the answers, but slowly."""

import pytest

from contact.jit import compiled


@pytest.fixture(scope="module", autouse=True)
def no_kernel_falls_back():
    """Fail a module after which a kernel runs by numba's ordinary compiler (`test_compiled` clears what it broke)."""
    yield
    assert not compiled.ORDINARY
