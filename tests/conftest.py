"""One BLAS thread, two sets of tests, and an order in which no worker waits for the compiler of the contact.

The matrices are small, and threads of several libraries in one process slow each other down.  In a fresh cache the
kernels of the contact take about a minute of two processors.  Two processes of their own compile them while the workers
are busy with the tests of the field, which need none.
"""

import gc
import os
import subprocess
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported, which reads it once

import numpy as np
import pytest
from hypothesis import settings

# no test measures time: an example may take long on a machine that is busy
settings.register_profile("thorough", deadline=None)
settings.register_profile("quick", deadline=None, max_examples=25)

_approx = pytest.approx


def _relative(expected, rel=None, abs=None, nan_ok=False):
    """`pytest.approx`, whose relative tolerance is relative: pytest adds 1e-12, which here may be a motion in m."""
    if abs is None and (rel is not None or np.any(expected)):
        rel, abs = 1e-6 if rel is None else rel, 0.0
    return _approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)


pytest.approx = _relative

ROOT = Path(__file__).parents[1]
THOROUGH = ROOT / "tests" / "thorough.txt"
KERNEL_PARTS = ("events", "averages")  # of tests/kernels.py
LONG = ("tests/studies/test_studies.py", "tests/test_documents.py")  # files: begun late, they would end alone
APART = ("tests/test_documents.py",)  # long files whose tests share nothing: any worker takes each of them
# folders, the documentation's examples of the product last
ORDER = ("tests/fem", "tests/oracles", "tests/contact", *LONG, "tests", "")
COMPILERS: list[subprocess.Popen] = []
gc.disable()  # while the tests are collected: what is made then stays


def pytest_configure(config):
    """Number of examples; hand out the files in the order below; in a whole run by several workers compile."""
    settings.load_profile("quick" if "not thorough" in config.option.markexpr else "thorough")
    config.option.loadscopereorder = False
    whole = config.args_source == config.ArgsSource.TESTPATHS and not config.option.collectonly
    if whole and getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        for part in KERNEL_PARTS:
            COMPILERS.append(subprocess.Popen([sys.executable, "-m", "tests.kernels", part], cwd=ROOT))


@pytest.fixture(autouse=True, scope="session")
def _small_pictures():
    """Files of pictures are 40 dots to the inch and not laid out: a third of the time.

    What a picture looks like is asked of its figure (`tests/studies/legible.py`), which is laid out.
    """
    from studies.record import plots

    whole = plots.new_figure

    def hasty(*given, **options):
        from matplotlib.layout_engine import PlaceHolderLayoutEngine

        figure, axes = whole(*given, **options)
        figure.set_layout_engine(PlaceHolderLayoutEngine(adjust_compatible=True, colorbar_gridspec=False))
        return figure, axes

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plots, "new_figure", hasty)
        patch.setattr(plots, "lay_out", lambda figure: figure.set_layout_engine(None))
        patch.setattr(plots, "DPI", 40)
        yield


def pytest_unconfigure(config):
    """End the compilers, which a complete run has outlived."""
    for each in COMPILERS:
        each.kill()
        each.wait()


def pytest_collection_finish():
    """Collect garbage again, but seldom, and not among the modules and tests that have come together."""
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)  # a compiler makes so many objects that the usual 700 cost it a tenth of its time
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out whole files, as ``--dist loadfile`` says, but the tests of files in APART one by one."""
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return nodeid if nodeid.startswith(APART) else super()._split_scope(nodeid)

    return ByFile(config, log) if config.getvalue("dist") == "loadfile" else None


@pytest.fixture(autouse=True, scope="module")
def _nothing_is_kept_for_other_modules(request):
    """Empty what the functions of a module of tests have cached, when its tests are over."""
    yield
    own = request.module.__name__
    for each in vars(request.module).values() if own.startswith("tests.") else ():
        if getattr(each, "__module__", None) == own and hasattr(each, "cache_clear"):
            each.cache_clear()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark the tests that `pytest` alone leaves out; put those of the field first, long files before short ones."""
    thorough = set(THOROUGH.read_text().splitlines())
    for item in items:
        if item.nodeid in thorough:
            item.add_marker(pytest.mark.thorough)
    items.sort(key=lambda item: next(k for k, folder in enumerate(ORDER) if item.nodeid.startswith(folder)))
