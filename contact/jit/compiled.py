"""Compilation of the kernels: by numba on first use, later loaded from a file of machine code.

- `formula` marks a few lines of arithmetic, inlined in kernels and plain Python for Python.
- `compiled` marks a function that numba compiles when Python first calls it, or as a part of a kernel that calls it.
- `summed` marks the same, with sums in the order that suits the processor.
- `callback` marks a function of numbers that kernels call by its address, so that they are compiled once for all such
  functions, as for a user's friction law.
- `native` marks the few kernels that Python calls. They allocate nothing and raise nothing, so that their machine code
  needs no runtime: it is optimised once as a whole and stored in a file that llvmlite loads. Numba is not imported
  then, whose import costs more time than a sweep.

With `NUMBA_DISABLE_JIT=1` all of them stay plain Python. If a file cannot be read, written, linked or loaded, numba's
ordinary compiler compiles the kernel instead. This takes some seconds and changes no answer (`ORDINARY` names such
kernels).

The files are stored in the first of these folders that can be written to: NUMBA_CACHE_DIR, the package's __pycache__,
the user's cache, the user's own folder among the temporary files. Their folder is named by a digest of all sources that
hold kernels or constants in kernels, of the versions of the compilers, and of the processor. A change of any of these
therefore compiles all kernels again. What is stored of the kernels of other packages is named by a digest of those
(`_other_package`).
"""

import ctypes
import getpass
import hashlib
import os
import stat
import struct
import tempfile
import threading
import time
import weakref
from collections.abc import Callable, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cache, cached_property, wraps
from importlib.util import find_spec
from math import prod
from pathlib import Path

from numpy import dtype, ndarray

from contact.jit.array_shapes import check_shapes

HERE = Path(__file__).parents[1]  # the package, with all its kernels
PACKAGE_CACHE = HERE / "__pycache__"
_MARKS = (b"@compiled", b"@formula", b"@native", b"@summed")
# modules whose constants are compiled into kernels, and the compilers themselves
_FROZEN = ("codes.py", "collocation.py", "radau.py", "problem.py", "compiled.py", "compiler.py", "short_pipeline.py")
PLAIN = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
_LOCK = threading.RLock()
# shapes of calls that a kernel remembers as fitting
MAX_KEPT_SHAPES = 1000
# s that a process waits for another that compiles the same kernel, which takes 10 to 20 s
MAX_WAIT = 120.0
_CODES = {dtype("<f8"): "f", dtype("<i8"): "i", dtype("<c16"): "c"}
# Tuples whose addresses are known, by identity, with what `_packed_argument` gives: those whose arrays have together at
# most so many numbers, so that what is kept alive is small, and at most so many
MAX_KEPT_NUMBERS, MAX_KEPT_TUPLES = 20_000, 200
_PACKED: dict = {}
_NOTHING = None, "", b"", ()  # the argument None, packed
_EMPTY = ctypes.c_double()
_EMPTY_ADDRESS = ctypes.addressof(_EMPTY)


def compiled(function):
    """Return the function, compiled by numba when it is needed; a decorator."""
    return function if PLAIN else Kernel(function)


def summed(function):
    """Return the function, compiled so that its sums may be reordered and vectorised; a decorator."""
    return function if PLAIN else Kernel(function, {"reassoc", "nsz"})


def formula(function):
    """Return the function, inlined in kernels and plain Python for Python (numbers or arrays); a decorator."""
    return function if PLAIN else Formula(function)


def native(types: str, shapes: Mapping[str, str] | None = None):
    """Return a decorator for a kernel that is called from Python often or first.

    Parameters
    ----------
    types : str
        One code per argument: f or i for a number, f1, i2, c1 ... for contiguous arrays of doubles, integers or complex
        numbers with so many axes, and t for a named tuple of numbers, arrays and further named tuples, or None.  The
        kernel returns an integer, a truth value or nothing.
    shapes : mapping of str to str, optional
        Shapes of arrays by argument, see `contact.jit.array_shapes`.
    """
    return lambda function: function if PLAIN else Native(function, tuple(types.split()), shapes)


def callback(name: str):
    """Return a decorator for a function that kernels call by its address; it takes numbers and returns one.

    The machine code is kept in a file of this name, which must change with all sources outside the package.
    """
    return lambda function: function if PLAIN else Callback(function, name)


def per_thread(make, most: int = 16):
    """Return a function that keeps what `make` returns for each thread and arguments; a decorator.

    A thread keeps at most `most` of them and drops all before it keeps one more.

    For work arrays: a kernel finds the same named tuples again, and need not pack them (`Native`). They end with their
    thread.
    """
    local = threading.local()

    @wraps(make)
    def kept(*arguments):
        arrays = vars(local)
        if arguments not in arrays:
            if len(arrays) >= most:
                arrays.clear()
            arrays[arguments] = make(*arguments)
        return arrays[arguments]

    return kept


_KERNELS: "weakref.WeakSet[Kernel]" = weakref.WeakSet()


class Kernel:
    """A function that numba compiles; called from Python or from another kernel."""

    def __init__(self, function, freedom=frozenset()):
        self.freedom = set(freedom)
        # A named tuple can hold a function of the package, such as one of a contact law. This word then represents it
        # among the argument types that name the cached file; the digest of the folder covers its source.
        self.word = f"{function.__module__}.{function.__qualname__}"
        self.function, self.__doc__, self.__name__ = function, function.__doc__, function.__name__
        self.__module__, self.__wrapped__ = function.__module__, function
        _KERNELS.add(self)

    def __call__(self, *arguments):
        """Run what numba has compiled."""
        return self.dispatcher(*arguments)

    @cached_property
    def dispatcher(self):
        """Numba's own, for calls from Python; cached on disk."""
        numba, folder = _numba(), _folder_of(self.function.__code__.co_filename)
        usual = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = folder or usual
        try:
            made = self._jitted(cache=folder is not None)
        finally:
            numba.config.CACHE_DIR = usual
        if folder is not None:
            from contact.jit.compiler import without_failing_cache

            without_failing_cache(made)
        return made

    def _jitted(self, **options):
        options = {"nogil": True, "error_model": "numpy", "fastmath": self.freedom} | options
        return _numba().njit(**options)(self.function)

    @property
    def inner(self):
        """Numba's own, for calls from other kernels: without wrappers for Python; one for all threads.

        While machine code is compiled it is another one, which counts no references (`contact.jit.short_pipeline`).
        """
        from contact.jit import compiler, short_pipeline

        bare = compiler.is_deferred()
        known = vars(self).get(_INNER[bare])
        if known is None:
            options = compiler.BARE | {"pipeline_class": short_pipeline.pipeline()} if bare else {}
            made = self._jitted(no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)
            _DISPATCHERS.append(made)
            known = vars(self).setdefault(_INNER[bare], made)  # of two threads at once, the first's
        return known


class Formula(Kernel):
    """A few lines of arithmetic: from Python they are run as Python, without waiting for a compiler."""

    def __call__(self, *arguments):
        """Run the function itself."""
        return self.function(*arguments)


class Native(Kernel):
    """A kernel that is kept as machine code."""

    def __init__(self, function, types, shapes=None):
        super().__init__(function)
        self.types, self.shapes = types, shapes or {}
        self._loaded, self._fitting, self._packed = {}, set(), [_NOTHING] * len(types)

    def __call__(self, *arguments):
        """Run the machine code; arrays must have the types that the kernel was declared with."""
        parts = []
        for k, (kind, argument) in enumerate(zip(self.types, arguments, strict=True)):
            part = self._packed[k]
            # the addresses of a named tuple that was also the last call's argument are known
            if argument is None or part[0] is not argument:
                part = (argument, *_packed_argument(self.__name__, kind, argument))
                # large arrays are not kept alive until the next call
                self._packed[k] = part if id(argument) in _PACKED else _NOTHING
            parts.append(part)
        lengths = tuple([part[3] for part in parts])
        if self.shapes and lengths not in self._fitting:
            self._check(arguments, lengths)
        words = " ".join([part[1] for part in parts])
        if words not in self._loaded:
            self._load(words, arguments)
        entry = self._loaded[words]
        if entry is None:
            return int(self.dispatcher(*arguments) or 0)
        table, answer = b"".join([part[2] for part in parts]), ctypes.c_int64()
        if entry(ctypes.byref(answer), ctypes.byref(ctypes.c_void_p()), table) != 0:
            raise RuntimeError(f"{self.__name__} has failed")  # kernels raise nothing: not reached
        return answer.value

    def _check(self, arguments, lengths):
        """Refuse arrays whose shapes do not fit; store shapes that do, so that they are checked once."""
        names = self.function.__code__.co_varnames[: len(arguments)]
        check_shapes(self.__name__, self.shapes, dict(zip(names, arguments, strict=True)))
        if len(self._fitting) < MAX_KEPT_SHAPES:
            self._fitting.add(lengths)

    def _load(self, words, arguments):
        """Load the function for arguments of these types from its file, which is written if there is none.

        If that fails, numba's ordinary compiler compiles the kernel. It raises an error of the kernel itself again.
        """
        package = _other_package(self.function.__code__.co_filename)
        name = f"{self.__module__}-{self.__name__}-{hashlib.sha256((words + package).encode()).hexdigest()[:8]}.o"
        with _LOCK:
            if words in self._loaded:  # by another thread
                return
            address = _kept_or_compiled(name, self.__name__, "machine_code", self, words.split(), arguments)
            self._loaded[words] = address and _ENTRY(address)


class Callback:
    """A function of numbers that kernels call by its address; see `callback`."""

    def __init__(self, function, name):
        self.function, self.__doc__, self.__name__ = function, function.__doc__, function.__name__
        self.name, self.count = name, function.__code__.co_argcount
        self.word = f"callback{self.count}"  # among the argument types of a kernel: any function of so many numbers

    def __call__(self, *arguments):
        """Run the function itself, as Python."""
        return self.function(*arguments)

    @cached_property
    def address(self):
        """Address of the C function: of its machine code or, if the function can allocate or raise, of numba's own.

        What raises an error in a kernel returns NaN there.
        """
        with _LOCK:
            address = _kept_or_compiled(f"{self.name}.o", self.name, "callback_code", self.function, self.count)
            if address is None:
                from contact.jit.compiler import guarded_callback

                self._numba = guarded_callback(self.function, self.count, _numba())
                address = self._numba.address
        return address


def _kept_or_compiled(name, called, make, *arguments):
    """Return the address of the machine code in a file, which is written if there is none; None if that fails.

    `make` of `contact.jit.compiler` makes the code. If anything fails here, such as a file that the installed llvmlite
    does not load, `ORDINARY` says why of what is `called` so, and what was half compiled is compiled afresh.
    """
    try:
        return _from_file(name) or _compiled_to_file(name, called, make, arguments)
    except Exception as failed:
        ORDINARY[called] = f"{type(failed).__name__}: {failed}"
        for kernel in _KERNELS:
            for name in _INNER.values():
                vars(kernel).pop(name, None)
        return None


# Dispatchers for other kernels are kept until the process ends. Numba's types hold only weak references to them and are
# looked up by the address of a function. A new law at the address of a deleted one would be given the dead type, with
# the error "underlying object has vanished".
_DISPATCHERS: list = []
_INNER = {False: "_inner", True: "_bare"}  # attributes of a `Kernel`; True: for machine code
# functions that a process calls, once each, when it has to wait for another that compiles the same kernel
MEANWHILE: list[Callable[[], None]] = []
# kernels and callbacks that numba's ordinary compiler compiles, and why
ORDINARY: dict[str, str] = {}


def _from_file(name):
    """Return the address of the code of a file in any folder, None without a complete file that can be loaded."""
    for folder in cache_folders():
        code = _read(Path(folder) / name)
        if code is not None:
            try:
                return _address(code)
            except Exception:  # the installed llvmlite does not load it: it is compiled again
                continue
    return None


def _compiled_to_file(name, called, make, arguments):
    """Return the address of machine code that is compiled now, which takes seconds, and stored if possible.

    A process waits for another one that compiles the same. What is `called` so is logged before and after.
    """
    import logging

    from contact.jit import compiler

    logger, folder = logging.getLogger(__name__), cache_folder()
    logger.debug("compiling kernel %s%s", called, "" if folder is None else ", once")
    if folder is None:
        address = _address(getattr(compiler, make)(*arguments, _numba()))
    else:
        path = Path(folder) / name
        with file_lock(path.with_suffix(".lock")):
            address = _from_file(name)
            if address is None:
                code = getattr(compiler, make)(*arguments, _numba())
                address = _address(code)
                _write(path, code)
    logger.debug("kernel %s is compiled", called)
    return address


@contextmanager
def file_lock(path):
    """Hold a file lock, or go on without one after MAX_WAIT or where there are no locks."""
    with ExitStack() as stack:
        try:
            import fcntl

            lock = stack.enter_context(path.open("w"))
            until = time.monotonic() + MAX_WAIT
            while time.monotonic() < until:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    if MEANWHILE:
                        MEANWHILE.pop()()
                    else:
                        time.sleep(0.05)
        except (ImportError, OSError):
            pass
        yield


def _packed_argument(name, kind, argument):
    """Return (type words, their values as 64-bit words, shapes of the arrays) of an argument of a kernel.

    A named tuple gives those of its fields, None nothing. Those of small tuples are kept: most of a problem's fields
    are those of the last problem.
    """
    if kind != "t":
        return _packed_fields(name, kind, [argument])
    if argument is None:
        return "", b"", ()
    known = _PACKED.get(id(argument))
    if known is not None and known[0] is argument:
        return known[1]
    packed = _packed_fields(name, kind, argument)
    if sum([prod(shape) for shape in packed[2]]) <= MAX_KEPT_NUMBERS:
        if len(_PACKED) >= MAX_KEPT_TUPLES:
            _PACKED.clear()
        _PACKED[id(argument)] = argument, packed
    return packed


def _packed_fields(name, kind, fields):
    """Return what `_packed_argument` returns, of the fields of an argument."""
    words, layout, values, shapes = [], [], [], []
    for field in fields:
        if isinstance(field, float) and kind in ("t", "f"):
            words.append("f")
            values.append(field)
            layout.append("d")
        elif isinstance(field, ndarray):
            shape = field.shape
            word = f"{_CODES.get(field.dtype)}{len(shape)}"
            if not field.flags.c_contiguous or word[0] == "N" or kind not in ("t", word):
                expected = f"{field.dtype.kind}{field.ndim}" if kind == "t" else kind
                raise TypeError(f"{name}: {expected} expected, got {field.dtype} {field.shape}")
            words.append(word)
            values.append(_array_address(field))
            values += shape
            layout.append("qqqqqqqq"[: 1 + len(shape)])
            shapes.append(shape)
        elif isinstance(field, Kernel):
            words.append(field.word)
        elif isinstance(field, Callback):
            words.append(field.word)
            values.append(field.address)
            layout.append("q")
        elif field is None or isinstance(field, tuple):
            word, packed, inner = _packed_argument(name, "t", field)
            words.append(word)
            values.append(packed)
            layout.append(f"{len(packed)}s")
            shapes += inner
        else:
            word = kind if kind != "t" else "i"
            words.append(word)
            values.append(field if word == "f" else int(field))
            layout.append("d" if word == "f" else "q")
    return " ".join(words), struct.pack("".join(layout), *values), tuple(shapes)


def _array_address(array):
    """Return the address of a contiguous array's numbers.

    Its buffer gives the address in a quarter of the time of `__array_interface__` (`python -m timeit`), but not that of
    an array without numbers, whose address no kernel reads, or that cannot be written to.
    """
    if array.size == 0:
        return _EMPTY_ADDRESS
    if array.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))
    return array.__array_interface__["data"][0]


def _read(path):
    """Return the machine code in a file that is whole, else None."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    return content[32:] if hashlib.sha256(content[32:]).digest() == content[:32] else None


def _write(path, code):
    """Write machine code to a file, atomically; if this fails it is compiled again next time."""
    part = path.with_suffix(f".{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(hashlib.sha256(code).digest() + code)
        part.replace(path)
    except (OSError, MemoryError):
        with suppress(OSError):  # a part of the file on a full disk
            part.unlink(missing_ok=True)


@cache
def _llvm():
    """Return llvmlite's binding, ready for this processor."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


# how object files begin: ELF, Mach-O, COFF
OBJECT_FILES = (b"\x7fELF", b"\xcf\xfa\xed\xfe", b"\x64\x86")
_ENGINES: list = []  # what holds the code that is in use
# the C function of a kernel's code; calls let other threads run
_ENTRY = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)


def _address(code):
    """Return the address of the C function in the machine code."""
    llvm = _llvm()
    if not code.startswith(OBJECT_FILES):  # llvmlite ends the process over what is no object file
        raise ValueError("no object file")
    machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _ENGINES.append(engine)
    address = engine.get_function_address("kernel")
    if not address:
        raise RuntimeError("the machine code has no entry")
    return address


@cache
def cache_folders():
    """Return the folders in which machine code is looked for, that of the user's choice first."""
    try:
        digest = source_digest()
    except Exception:  # compilers or processor cannot be identified: nothing is stored
        return ()
    chosen, user = os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")
    home = Path(user) if user else _home() and _home() / ".cache"
    places = [Path(chosen) if chosen else None, PACKAGE_CACHE, home and home / "sawmotor"]
    places.append(_temporary() if _is_own(_temporary()) else None)
    return tuple(str(place / f"kernels-{digest}") for place in places if place is not None)


@cache
def cache_folder():
    """Return the first folder that can be written to, None if there is none."""
    for folder in cache_folders():
        if _is_writable(Path(folder)):
            return folder
    try:
        _temporary().mkdir(mode=0o700)
    except OSError:
        return None
    cache_folders.cache_clear()
    return next((folder for folder in cache_folders() if _is_writable(Path(folder))), None)


@cache
def _folder_of(file):
    """Return the folder for what numba keeps of a file's kernels.

    Of another package than this one it is named by the digest of that package's kernels (`_other_package`).
    """
    folder, other = cache_folder(), _other_package(file)
    return folder if folder is None or not other else str(Path(folder) / other)


@cache
def _other_package(file):
    """Return the name of the package of a file and a digest of its kernels; empty for this package.

    The digest is that of the files that hold kernels and of those beside them, which hold their constants: numba itself
    looks at the kernel's own file alone.
    """
    root = Path(file)
    while (root.parent / "__init__.py").is_file():
        root = root.parent
    if root == HERE or root.suffix:
        return ""
    texts = {path: path.read_bytes() for path in sorted(root.rglob("*.py"))}
    folders = {path.parent for path, text in texts.items() if any(mark in text for mark in _MARKS)}
    digest = hashlib.sha256(b"".join(text for path, text in texts.items() if path.parent in folders))
    return f"{root.name}-{digest.hexdigest()[:16]}"


def _home():
    """Return the user's home, None without one."""
    try:
        return Path.home()
    except (RuntimeError, KeyError):
        return None


def _is_writable(folder):
    """Return True if a file can be made in a folder, which is made if need be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _temporary():
    """Return the user's folder among the temporary files: what serves without a home."""
    user = os.getuid() if hasattr(os, "getuid") else getpass.getuser()
    return Path(tempfile.gettempdir()) / f"sawmotor-{user}"


def _is_own(folder):
    """Return True if a folder exists, belongs to the user and cannot be written to by others.

    The machine code in it is run without further checks.
    """
    try:
        found = folder.lstat()
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return stat.S_ISDIR(found.st_mode)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077


def source_digest():
    """Return 16 hexadecimal digits that change with the kernels' sources, the compilers and the processor."""
    import llvmlite

    llvm, digest = _llvm(), hashlib.sha256()
    for path in sorted(HERE.rglob("*.py")):
        text = path.read_bytes()
        if any(mark in text for mark in _MARKS) or path.name in _FROZEN:
            digest.update(text)
    # numba's version from its folder: importlib.metadata and numba itself cost more than the kernels
    places = Path(find_spec("numba").origin).parents[1].glob("numba-*.dist-info")
    parts = llvmlite.__version__, *sorted(place.name for place in places), llvm.get_host_cpu_name()
    digest.update(" ".join((*parts, llvm.get_host_cpu_features().flatten())).encode())
    return digest.hexdigest()[:16]


@cache
def _numba():
    """Return numba, taught that a `Kernel` in a kernel is a function, and a `Callback` a pointer to one."""
    import numba
    from numba.core import types
    from numba.extending import typeof_impl

    from contact.jit.compiler import pointer_type

    @typeof_impl.register(Kernel)
    def _(kernel, context):
        return types.Dispatcher(kernel.inner)

    @typeof_impl.register(Callback)
    def _(callback, context):
        return pointer_type(callback)

    return numba
