"""The kernels' machine code: broken on purpose in every way a machine may break it, the answer stays the same."""

import errno
import gc
import hashlib
import os
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import FunctionType
from typing import NamedTuple

import llvmlite
import numpy as np
import pytest

from contact import plane, steady
from contact.events.collocation import collocation
from contact.jit import compiled, compiler, kernels
from contact.plane import SurfaceWaves
from contact.roots import interpolate
from tests.contact import motors, plane_motors

NOWHERE = Path("/proc/nowhere")  # where nobody can write, not even the superuser


def count(values, limit):
    """Count the values below a limit, and double them."""
    number = 0
    for k in range(values.size):
        if values[k] < limit:
            number += 1
        values[k] *= 2.0
    return number


def answer():
    """Return what a kernel that has just been imported makes of some numbers, and the kernel."""
    kernel = compiled.Native(count, ("f1", "f"))
    values = np.array([1.0, 2.0, 3.0, 4.0])
    return (kernel(values, 2.5), *values), kernel


RIGHT = (2, 2.0, 4.0, 6.0, 8.0)


def homeless():
    """Take the place of `Path.home` on a machine whose user has none."""
    raise RuntimeError("no home")


@pytest.fixture
def places(monkeypatch, tmp_path):
    """Take away every folder; return the environment to give some back."""
    compiled.cache_folders.cache_clear()
    compiled.cache_folder.cache_clear()
    compiled.ORDINARY.clear()
    monkeypatch.setattr(compiled, "PACKAGE_CACHE", NOWHERE)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.setattr(tempfile, "tempdir", str(NOWHERE))
    yield monkeypatch
    compiled.cache_folders.cache_clear()
    compiled.cache_folder.cache_clear()
    compiled.ORDINARY.clear()


def files(folder):
    """Return the files of machine code below a folder."""
    return sorted(Path(folder).rglob("*.o"))


def test_without_any_folder_the_answer_is_the_same_and_nothing_is_promised(places):
    places.setenv("NUMBA_CACHE_DIR", str(NOWHERE))
    assert answer()[0] == RIGHT
    assert compiled.cache_folder() is None
    assert not kernels.ready()
    assert "every start" in kernels.how_often()
    # the compiler for calls from Python keeps nothing either
    assert compiled.Kernel(count)(np.array([1.0]), 2.0) == 1


@pytest.mark.parametrize("name", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "home", "package"])
def test_the_first_folder_that_can_be_written_to_keeps_the_kernels(places, tmp_path, name):
    if name == "home":
        places.setattr(Path, "home", lambda: tmp_path)
    elif name == "package":
        places.setenv("NUMBA_CACHE_DIR", str(NOWHERE))
        places.setattr(compiled, "PACKAGE_CACHE", tmp_path)
    else:
        places.setenv(name, str(tmp_path))
    assert kernels.how_often() == "once"
    assert answer()[0] == RIGHT
    assert len(files(tmp_path)) == 1
    assert kernels.ready()
    # the next start does not compile
    places.setattr(compiler, "machine_code", None)
    assert answer()[0] == RIGHT
    assert not compiled.ORDINARY


@pytest.mark.parametrize("kept", [True, False])
def test_a_kernel_that_is_compiled_is_logged_and_one_that_is_loaded_is_not(places, tmp_path, caplog, kept):
    if kept:
        places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    expected = [f"compiling kernel count{', once' if kept else ''}", "kernel count is compiled"]
    with caplog.at_level("DEBUG", "contact"):
        answer()
        assert caplog.messages == expected
        answer()
    assert caplog.messages[2:] == ([] if kept else expected)


def test_without_a_home_the_kernels_lie_in_a_folder_that_only_the_user_can_write_to(places, tmp_path):
    places.setattr(tempfile, "tempdir", str(tmp_path))
    assert answer()[0] == RIGHT
    (file,) = files(tmp_path)
    own = tmp_path / f"sawmotor-{os.getuid()}"
    assert own in file.parents
    assert own.stat().st_mode & 0o777 == 0o700
    assert kernels.how_often() == "once"


@pytest.mark.parametrize("spoiled", ["open to others", "a link", "somebody else's"])
def test_a_folder_that_somebody_else_could_have_filled_is_not_used(places, tmp_path, spoiled):
    places.setattr(tempfile, "tempdir", str(tmp_path))
    if spoiled == "somebody else's":
        user = os.getuid()
        places.setattr(os, "getuid", lambda: user + 1)
    own = tmp_path / f"sawmotor-{os.getuid()}"
    if spoiled == "a link":
        (tmp_path / "elsewhere").mkdir()
        own.symlink_to(tmp_path / "elsewhere")
    else:
        own.mkdir()
        own.chmod(0o777 if spoiled == "open to others" else 0o700)
    assert compiled.cache_folder() is None
    assert answer()[0] == RIGHT
    assert not files(tmp_path)


@pytest.mark.parametrize("damage", ["cut", "wrong digest", "no machine code", "no entry"])
def test_a_file_that_cannot_be_used_is_made_anew(places, tmp_path, damage):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert answer()[0] == RIGHT
    (file,) = files(tmp_path)
    whole = file.read_bytes()
    if damage == "cut":
        file.write_bytes(whole[: len(whole) // 2])
    elif damage == "wrong digest":
        file.write_bytes(bytes(32) + whole[32:])
    else:
        code = b"not an object file" if damage == "no machine code" else whole[32:].replace(b"kernel", b"nobody")
        file.write_bytes(hashlib.sha256(code).digest() + code)
    assert answer()[0] == RIGHT
    content = file.read_bytes()
    assert hashlib.sha256(content[32:]).digest() == content[:32]
    places.setattr(compiler, "machine_code", None)  # what was made anew serves
    assert answer()[0] == RIGHT
    assert not compiled.ORDINARY


FAULTS = {
    "full": OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
    "broken": OSError(errno.EIO, os.strerror(errno.EIO)),
    "memory": MemoryError(),
}


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
@pytest.mark.parametrize("operation", ["write_bytes", "replace"])
def test_machine_code_that_cannot_be_kept_is_compiled_and_leaves_no_part(places, tmp_path, fault, operation):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert kernels.how_often() == "once"
    plain = getattr(Path, operation)

    def fail(path, *arguments):
        if operation == "write_bytes":
            plain(path, arguments[0][:100])
        raise fault

    with places.context() as disk:
        disk.setattr(Path, operation, fail)
        assert answer()[0] == RIGHT
    assert not compiled.ORDINARY
    assert not [each for each in tmp_path.rglob("*") if each.is_file() and each.suffix != ".lock"]
    assert answer()[0] == RIGHT
    assert len(files(tmp_path)) == 1


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_what_numba_cannot_keep_is_compiled_all_the_same(places, tmp_path, fault):
    from numba.core.caching import IndexDataCacheFile

    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def fail(*_):
        raise fault

    with places.context() as disk:
        disk.setattr(IndexDataCacheFile, "save", fail)
        assert compiled.Kernel(count)(np.array([1.0, 4.0]), 2.5) == 1
        disk.setattr(IndexDataCacheFile, "load", fail)
        assert compiled.Kernel(count)(np.array([1.0, 4.0]), 2.5) == 1


def test_another_version_of_the_compiler_has_its_own_folder(places, tmp_path):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert answer()[0] == RIGHT
    places.setattr(llvmlite, "__version__", llvmlite.__version__ + "9")
    compiled.cache_folders.cache_clear()
    compiled.cache_folder.cache_clear()
    assert not kernels.ready()
    assert answer()[0] == RIGHT
    assert len(files(tmp_path)) == 2


def gone(*arguments):
    raise AttributeError("a private name of numba is gone")


@pytest.mark.parametrize("name", ["deferred_library", "lowered", "optimised"])
def test_without_a_private_part_of_numba_its_ordinary_compiler_serves(places, tmp_path, name):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    places.setattr(compiler, name, gone)
    found, kernel = answer()
    assert found == RIGHT
    assert compiled.ORDINARY == {"count": "AttributeError: a private name of numba is gone"}
    assert gc.isenabled()
    values = np.array([1.0, 5.0])
    assert (kernel(values, 2.5), *values) == (1, 2.0, 10.0)


def test_without_what_llvmlite_says_of_the_processor_nothing_is_kept(places, tmp_path):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    places.setattr(compiled, "source_digest", gone)
    assert answer()[0] == RIGHT
    assert not files(tmp_path)


def test_threads_do_not_try_again_what_cannot_be_kept(places):
    # each attempt lets go of what the others' ordinary compiler is at work on
    tried = []

    def slowly(*arguments):
        tried.append(time.sleep(0.2))
        gone()

    places.setattr(compiler, "lowered", slowly)
    kernel = compiled.Native(count, ("f1", "f"))
    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(lambda k: kernel(np.array([1.0, k]), 2.5), (2.0, 3.0)))
    assert answers == [2, 1]
    assert len(tried) == 1


def test_a_process_waits_for_another_that_compiles_the_same_kernel(places, tmp_path):
    fcntl = pytest.importorskip("fcntl")
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert answer()[0] == RIGHT
    (file,) = files(tmp_path)
    content = file.read_bytes()
    file.unlink()
    places.setattr(compiler, "machine_code", None)  # another process compiles
    with file.with_suffix(".lock").open("w") as lock, ThreadPoolExecutor(1) as pool:
        fcntl.flock(lock, fcntl.LOCK_EX)
        waiting = pool.submit(answer)
        time.sleep(0.2)
        assert not waiting.done()
        file.write_bytes(content)
        fcntl.flock(lock, fcntl.LOCK_UN)
        assert waiting.result()[0] == RIGHT
    assert not compiled.ORDINARY


def test_a_process_does_not_wait_for_ever(places, tmp_path):
    fcntl = pytest.importorskip("fcntl")
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    places.setattr(compiled, "MAX_WAIT", 0.1)
    assert answer()[0] == RIGHT
    (file,) = files(tmp_path)
    file.unlink()
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert answer()[0] == RIGHT
    assert files(tmp_path) == [file]


def halves(values):
    """Return both halves of an array."""
    return values[: values.size // 2], values[values.size // 2 :]


def test_what_machine_code_shares_counts_references_when_python_calls_it(places, tmp_path):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    shared = compiled.Kernel(halves)

    def sum_of_first(values):
        first, second = shared(values)
        return first[0] + 2 * second[0]

    def both(values):
        first, second = shared(values)
        return shared(first), second

    assert compiled.Native(sum_of_first, ("i1",))(np.arange(1, 9)) == 1 + 2 * 5
    assert not compiled.ORDINARY
    # without counts, the arrays that the next call returns would not keep their memory
    (first, second), last = compiled.Kernel(both)(np.arange(1000) + 0)
    np.testing.assert_array_equal(np.concatenate([first, second, last]), np.arange(1000))
    assert not compiler.is_deferred()


def test_numbas_own_functions_are_back_after_a_kernel_even_one_that_fails(places, tmp_path):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    from llvmlite.ir.types import Type
    from numba.core import event
    from numba.core.base import BaseContext
    from numba.core.ir import Inst
    from numba.core.types.functions import BaseFunction

    owners = Inst, BaseFunction, Type, BaseContext, event
    usual = [dict(vars(owner)) for owner in owners]
    assert answer()[0] == RIGHT
    places.setattr(compiler, "lowered", gone)
    compiled.Native(total, ("t",))(Weights(np.array([1.5])))
    assert compiled.ORDINARY
    assert [dict(vars(owner)) for owner in owners] == usual


class Weights(NamedTuple):
    values: np.ndarray


def total(weights):
    """Return the sum of twice the weights."""
    twice = 0
    for k in range(weights.values.size):
        twice += 2 * weights.values[k]
    return twice


def test_arrays_of_another_type_have_their_own_machine_code(places, tmp_path):
    # a field of a named tuple is declared by nobody: the bits of integers are no numbers
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    kernel = compiled.Native(total, ("t",))
    assert kernel(Weights(np.array([1.5, 2.0]))) == 7
    assert kernel(Weights(np.array([3, 4]))) == 14
    assert not compiled.ORDINARY
    assert len(files(tmp_path)) == 2


def test_arrays_that_cannot_be_written_to_or_have_no_numbers_reach_a_kernel(places):
    # the address of either is not that of its buffer (`compiled._array_address`)
    kernel, values = compiled.Native(total, ("t",)), np.array([1.5, 2.0])
    values.setflags(write=False)
    assert kernel(Weights(values)) == 7
    assert kernel(Weights(np.empty(0))) == 0
    with pytest.raises(TypeError, match="f1 expected"):
        kernel(Weights(np.ones(4)[::2]))


def test_a_kernel_keeps_no_large_arrays_alive(places):
    kernel = compiled.Native(total, ("t",))
    weights = Weights(np.ones(compiled.MAX_KEPT_NUMBERS + 1))
    alive = weakref.ref(weights.values)
    assert kernel(weights) == 2 * weights.values.size
    del weights
    assert alive() is None


def read_off(sigma, bary, values, at):
    """Replace a place by the interpolant there: a kernel that calls another."""
    at[0] = interpolate(at[0], sigma, bary, values)
    return 0


def test_kernels_that_call_others_are_the_same_by_numbas_ordinary_compiler(places):
    table = collocation(12)
    found, lowered = [], interpolate.inner
    for broken in (False, True):
        if broken:
            places.setattr(compiler, "optimised", gone)
        at = np.array([0.3])
        compiled.Native(read_off, ("f1", "f1", "f1", "f1"))(table.sigma, table.bary, np.cos(table.sigma), at)
        found.append(at[0])
        assert ("read_off" in compiled.ORDINARY) == broken
    assert interpolate.inner is not lowered, "what was made for the machine code is not used again"
    assert found[0] == pytest.approx(np.cos(0.3), rel=1e-10)  # truncation of twelve points
    assert found[1] == pytest.approx(found[0], rel=1e-13)


class Curve(NamedTuple):
    """A function that is called by its address, as one of a user's law."""

    height: Callable


def risen(curve, values):
    """Replace values by the heights of a curve there."""
    for k in range(values.size):
        values[k] = curve.height(values[k], 2.0)
    return 0


def parabola(x, factor):
    return factor * x * x


def line(x, factor):
    return factor * x


def listed(x, factor):
    terms = [x]  # allocates
    terms.append(factor)
    return sum(terms)


def bounded(x, factor):
    if x > 2.5:
        raise ValueError
    return factor * x


def raised(function, kernel):
    """Return what a kernel makes of 1, 2 and 3 by a function under the address of a new callback."""
    values = np.array([1.0, 2.0, 3.0])
    kernel(Curve(compiled.Callback(function, f"test-{function.__name__}")), values)
    return list(values)


def test_one_kernel_serves_all_functions_that_it_calls_by_address(places, tmp_path):
    places.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for _ in range(2):
        kernel = compiled.Native(risen, ("t", "f1"))
        assert raised(parabola, kernel) == [2.0, 8.0, 18.0]
        assert raised(line, kernel) == [2.0, 4.0, 6.0]
        assert len(files(tmp_path)) == 3
        # the next start does not compile
        places.setattr(compiler, "machine_code", None)
        places.setattr(compiler, "callback_code", None)
    assert not compiled.ORDINARY


def test_a_function_that_allocates_or_raises_is_called_by_address_too(places):
    kernel = compiled.Native(risen, ("t", "f1"))
    assert raised(listed, kernel) == [3.0, 4.0, 5.0]
    np.testing.assert_array_equal(raised(bounded, kernel), [2.0, 4.0, np.nan])
    assert compiled.ORDINARY.keys() == {"test-listed", "test-bounded"}


def test_numbas_ordinary_compiler_calls_by_address_too(places):
    places.setattr(compiler, "optimised", gone)
    kernel = compiled.Native(risen, ("t", "f1"))
    assert raised(parabola, kernel) == [2.0, 8.0, 18.0]
    assert compiled.ORDINARY.keys() == {"test-parabola", "risen"}


def larger(values, limit):
    """Replace the first value by the largest of three numbers: a function of numba's own."""
    values[0] = max(values[0], limit, 2.0 * limit)
    return 0


def test_what_numba_compiles_for_the_machine_code_serves_other_functions(places):
    for kernel in (compiled.Native(larger, ("f1", "f")), compiled.Kernel(larger)):
        values = np.array([1.0])
        kernel(values, 0.75)
        assert values == [1.5]
    assert not compiled.ORDINARY


def test_shapes_that_a_kernel_declares_are_looked_at_before_it_runs(places):
    kernel = compiled.Native(count, ("f1", "f"), {"values": "4"})
    assert kernel(np.arange(4.0), 2.5) == kernel(np.arange(4.0), 2.5) == 3
    with pytest.raises(ValueError, match=r"count: values has the shape \(3,\), but \(4\) is expected"):
        kernel(np.arange(3.0), 2.5)


@pytest.mark.skipif(compiled.PLAIN, reason="needs numba")
def test_a_law_that_is_gone_is_not_taken_for_a_new_one():
    """Numba finds its types by the address of a function, which a new law's function may have again."""
    import numba

    code = compile("def sliding(force):\n    return 2.0 * force\n", "law.py", "exec").co_consts[0]

    class Law(NamedTuple):
        sliding: compiled.Formula

    records = []
    gc.freeze()  # only what the laws leave behind is collected
    for _ in range(20):
        kernel = compiled.formula(FunctionType(code, {"__name__": "law"}, "sliding"))
        record = compiler.argument_type("t", Law(kernel), iter(["t"] * 2), numba)
        assert record.fields["sliding"].dispatcher is kernel.inner
        records.append(record)
        del kernel, record
        gc.collect()


COMPILED = "@compiled\ndef scaled(x):\n    return factors.FACTOR * x\n\n\nprint(scaled(2.0))\n"
NATIVE = (
    '@native("f f1")\ndef scaled(x, out):\n    out[0] = factors.FACTOR * x\n    return 0\n\n\n'
    "out = numpy.zeros(1)\nscaled(2.0, out)\nprint(out[0])\n"
)


@pytest.mark.parametrize("source", [COMPILED, NATIVE], ids=["compiled", "native"])
def test_kernels_of_another_package_follow_its_constants(tmp_path, source):
    package = tmp_path / "own"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "kernel.py").write_text(
        "import numpy\n\nfrom contact.jit.compiled import compiled, native\nfrom own import factors\n\n\n" + source
    )
    root = str(Path(compiled.__file__).parents[2])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join((str(tmp_path), root))}
    for factor in (3.0, 3.0, 5.0):
        (package / "factors.py").write_text(f"FACTOR = {factor}\n")
        command = [sys.executable, "-B", "-m", "own.kernel"]
        found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert float(found.stdout) == 2.0 * factor


def test_numba_caches_no_kernel_that_takes_the_functions_of_a_law():
    """It knows them in no other process: each compiles again, and after some twenty the index cannot be written."""
    wave = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-3e-9j, 1e-9, 5e-9]]])
    light = plane_motors.ball(mass=1e-7, normal_damping=0.05)
    plane.steady(light, wave, tolerance=1e-3, method="exact")
    for method in ("exact", "stepped"):
        plane.burst(light, wave, duration=2e-6, after=0.0, tolerance=1e-2, samples=1, method=method)
    steady(motors.slider(), motors.orbit(5e-9), tolerance=1e-3, method="exact")
    kept, seen = {}, set()
    for name in [name for name in sys.modules if name.startswith("contact.")]:
        for kernel in vars(sys.modules[name]).values():
            if not isinstance(kernel, compiled.Kernel):
                continue
            seen.add(kernel.word)
            if "dispatcher" in vars(kernel):
                kept[kernel.word] = str(kernel.dispatcher.signatures)
    assert "contact.plane.plane_equations.fill_surface" in seen
    assert {word for word, signatures in kept.items() if "Dispatcher" in signatures} == set()
