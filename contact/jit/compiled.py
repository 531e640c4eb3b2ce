"""Compilation of the kernels: by numba on first use, from a file of machine code ever after.

`compiled` marks a function that numba compiles when it is first called from Python, or together with a kernel that
calls it.  `native` marks the few kernels that do the work.  Such a kernel allocates nothing and raises nothing, so its
machine code stands alone: it is optimised once, as a whole, and kept in a file that llvmlite loads without numba, whose
import alone costs more than a sweep.  `NUMBA_DISABLE_JIT=1` leaves all of them plain Python.

The files lie in a folder named after a digest of every source that holds kernels or constants that they freeze, of the
compilers' versions and of the processor, so a change in any of them compiles anew and nothing stale is ever run.
"""

import ctypes
import hashlib
import os
import struct
import threading
from functools import cache, cached_property
from pathlib import Path

HERE = Path(__file__).parents[1]  # the package, with all its kernels
_FROZEN = ("collocation.py", "problem.py", "compiled.py", "compiler.py")
_PLAIN = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
_LOCK = threading.RLock()
_DTYPES = {"f": "float64", "i": "int64", "c": "complex128"}


def compiled(function):
    """Return the function, compiled by numba when it is needed; a decorator."""
    return function if _PLAIN else Kernel(function)


def summed(function):
    """Return the function, compiled like the others, its sums in the order that suits the processor; a decorator."""
    return function if _PLAIN else Kernel(function, {"reassoc", "nsz"})


def native(types: str):
    """Return a decorator for a kernel that is called from Python often or first.

    Parameters
    ----------
    types : str
        One word per argument: f or i for a number, f1, i2, c1 ... for contiguous arrays of doubles, integers or complex
        numbers with so many axes, and t for a named tuple of numbers, arrays and further named tuples, or None.  The
        kernel returns an integer, a truth value or nothing.
    """
    return lambda function: function if _PLAIN else Native(function, tuple(types.split()))


def plain(kernel):
    """Return a kernel's function itself: for a few numbers it is quicker than waking numba."""
    return getattr(kernel, "function", kernel)


class Kernel:
    """A function that numba compiles; called from Python or from another kernel."""

    def __init__(self, function, freedom=frozenset()):
        self.freedom = set(freedom)
        self.function, self.__doc__, self.__name__ = function, function.__doc__, function.__name__
        self.__module__, self.__wrapped__ = function.__module__, function

    def __call__(self, *arguments):
        """Run what numba has compiled."""
        return self.dispatcher(*arguments)

    @cached_property
    def dispatcher(self):
        """Numba's own, for calls from Python; cached on disk."""
        numba = _numba()
        usual = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = _folder()
        try:
            return numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=self.freedom)(
                self.function
            )
        finally:
            numba.config.CACHE_DIR = usual

    @cached_property
    def inner(self):
        """Numba's own, for calls from other kernels: without wrappers for Python."""
        return _numba().njit(nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)(
            self.function
        )


class Native(Kernel):
    """A kernel that is kept as machine code."""

    def __init__(self, function, types):
        super().__init__(function)
        self.types, self._loaded = types, {}

    def __call__(self, *arguments):
        """Run the machine code; arrays must have the types that the kernel was declared with."""
        words, values = [], []
        for kind, argument in zip(self.types, arguments, strict=True):
            for word, part in _parts(kind, argument):
                words.append(word)
                if len(word) == 1:
                    values.append(float(part) if word == "f" else int(part))
                else:
                    face = part.__array_interface__
                    if (
                        face["strides"] is not None
                        or part.dtype != _DTYPES[word[0]]
                        or part.ndim != int(word[1])
                    ):
                        raise TypeError(f"{self.__name__}: {word} expected, got {part.dtype} {part.shape}")
                    values.append(face["data"][0])
                    values.extend(part.shape)
        entry, layout = self._loaded.get(len(words)) or self._load(words, arguments)
        table, answer = struct.pack(layout, *values), ctypes.c_int64()
        if entry(ctypes.byref(answer), ctypes.byref(ctypes.c_void_p()), table, table) != 0:
            raise RuntimeError(f"{self.__name__} has failed")  # kernels raise nothing: not reached
        return answer.value

    def _load(self, words, arguments):
        """Return (function, layout of its table of arguments) from the file, which is made if it is not there."""
        with _LOCK:
            path = Path(_folder()) / f"{self.__module__}-{self.__name__}-{len(words)}.o"
            code = _read(path)
            if code is None:
                code = _machine_code(self, words, arguments)
                _write(path, code)
            entry = _entry(code)
            layout = "".join("d" if w == "f" else "q" * (1 + int(w[1:] or 0)) for w in words)
            self._loaded[len(words)] = entry, layout
            return self._loaded[len(words)]


def _parts(kind, argument):
    """Yield (type word, value); a named tuple gives those of its fields, None nothing."""
    if kind != "t":
        yield kind, argument
    elif argument is not None:
        for field in argument:
            yield from _parts(_kind(field), field)


def _kind(field):
    """Return the type word of a field of a named tuple."""
    if field is None or isinstance(field, tuple):
        return "t"
    if hasattr(field, "dtype") and field.ndim > 0:
        return f"{field.dtype.kind}{field.ndim}"
    return "f" if isinstance(field, float) else "i"


def _read(path):
    """Return the machine code in a file that is whole, else None."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    return content[32:] if hashlib.sha256(content[32:]).digest() == content[:32] else None


def _write(path, code):
    """Keep machine code in a file, in one piece; where nothing can be written it is compiled again next time."""
    part = path.with_suffix(f".{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(hashlib.sha256(code).digest() + code)
        part.replace(path)
    except OSError:
        return


@cache
def _llvm():
    """Return llvmlite's binding, ready for this processor."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


_ENGINES = []  # what holds the code that is in use


def _entry(code):
    """Return the C function in the machine code; calls let other threads run."""
    llvm = _llvm()
    machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _ENGINES.append(engine)
    pointer = ctypes.c_void_p
    kind = ctypes.CFUNCTYPE(ctypes.c_int32, pointer, pointer, ctypes.c_char_p, ctypes.c_char_p)
    return kind(engine.get_function_address("kernel"))


@cache
def _folder():
    usual = os.environ.get("NUMBA_CACHE_DIR")
    if not usual:
        # where the package may not be written to, the user's own cache serves
        own = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "sawmotor"
        usual = HERE / "__pycache__" if os.access(HERE, os.W_OK) else own
    return str(Path(usual) / f"kernels-{_digest()}")


def _digest():
    from importlib.metadata import version

    llvm = _llvm()
    digest = hashlib.sha256()
    for path in sorted(HERE.rglob("*.py")):
        text = path.read_bytes()
        if b"@compiled" in text or b"@native" in text or path.name in _FROZEN:
            digest.update(text)
    digest.update(f"{version('numba')} {version('llvmlite')} {llvm.get_host_cpu_name()}".encode())
    digest.update(llvm.get_host_cpu_features().flatten().encode())
    return digest.hexdigest()[:16]


@cache
def _numba():
    """Return numba, taught that a `Kernel` in a kernel is a function."""
    import numba
    from numba.core import types
    from numba.extending import typeof_impl

    @typeof_impl.register(Kernel)
    def _(kernel, context):
        return types.Dispatcher(kernel.inner)

    return numba


def _machine_code(kernel, words, arguments):
    from contact.jit.compiler import machine_code

    return machine_code(kernel, words, arguments, _numba())
