"""Every kernel of the package must compile by the project's own way: the fallback gives the answers, but slowly."""

import pytest

from contact.jit import compiled


@pytest.fixture(scope="module", autouse=True)
def _small_kernels_are_python(request):
    """Let a kernel that a test calls by itself run as the Python that it is: to compile it takes seconds.

    The kernels that do the work (`compiled.native`) stay compiled, with all that they call.
    """
    with pytest.MonkeyPatch.context() as patch:
        if not request.module.__name__.endswith("test_compiled"):
            patch.setattr(compiled.Kernel, "__call__", lambda kernel, *given: kernel.function(*given))
        yield


@pytest.fixture(scope="module", autouse=True)
def no_kernel_falls_back():
    """Fail a module after which a kernel runs by numba's ordinary compiler (`test_compiled` clears what it broke)."""
    yield
    assert not compiled.ORDINARY
