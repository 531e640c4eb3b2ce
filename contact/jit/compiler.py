"""Ahead-of-time machine code of a kernel: numba types and lowers it, LLVM (by llvmlite) optimises it once as a whole.

Numba would optimise every function by itself and again inside each that calls it, and wrap each for Python.  Here
optimisation waits until all functions are linked into one module with one entry, so that LLVM runs once and inlines
across them.  Reference counts are left out, for nothing is allocated, and so are the passes that no kernel needs
(`contact.jit.short_pipeline`).

The entry takes the address of a table of 64-bit words, in which the arguments lie one after the other: a number is one
word, an array 1 + ndim words (its address and its lengths), a named tuple the words of its fields.  Kernels and None
take none.
"""

import gc
import hashlib
import math
import re
import threading
from contextlib import contextmanager
from functools import cache
from operator import attrgetter

from contact.jit.short_pipeline import pipeline, slow_parts_replaced

# the only outside functions that a kernel may call: LLVM's intrinsics, mathematics and memory functions of the C
# library, and complex arithmetic of the compiler's runtime
_LIBRARY = re.compile(
    r"llvm\..*|sin|cos|tan|sqrt|asin|acos|atan|atan2|hypot|pow|exp|log|floor|ceil|fmod|cbrt|mem(set|cpy|move)|__\w+c3"
)
# options of numba for functions without Python's or numba's memory
BARE = {"nogil": True, "error_model": "numpy", "_nrt": False}
_STATE = threading.local()


def machine_code(kernel, words: list[str], arguments: tuple, numba) -> bytes:
    """Return the object file of a kernel, its entry named `kernel`.

    Parameters
    ----------
    kernel : the kernel as decorated by `contact.jit.compiled.native`.
    words : types of the arguments' leaves in order: "f", "i", "c" for a float, int or complex number, with the number
        of axes behind it ("f2") for an array.
    arguments : an example, for the classes of the named tuples among them.
    """
    with _deferred():
        library = lowered(kernel, words, arguments, numba)
    return optimised(library)


def callback_code(function, count: int, numba) -> bytes:
    """Return the object file of a C function `kernel` of so many doubles that returns one."""
    with _deferred():
        library = numba.cfunc(_signature(count), pipeline_class=pipeline(), **BARE)(function)._library
    return optimised(library, wrapper=True)


def guarded_callback(function, count: int, numba):
    """Return numba's own C callback of a function that may allocate or raise; where it raises, it returns NaN."""
    numbers = ", ".join(f"number{k}" for k in range(count))
    scope = {"function": numba.njit(error_model="numpy")(function), "nan": math.nan}
    source = (
        f"def guarded({numbers}):\n"
        f"    try:\n"
        f"        return float(function({numbers}))\n"
        f"    except Exception:\n"
        f"        return nan\n"
    )
    exec(source, scope)
    return numba.cfunc(_signature(count), error_model="numpy")(scope["guarded"])


def _signature(count):
    """Return numba's signature of a function of so many doubles that returns one."""
    from numba.core.types import float64

    return float64(*[float64] * count)


_ADDRESS = attrgetter("address")


def pointer_type(callback):
    """Return numba's type of a pointer to a C function, as it has for one of ctypes."""
    from numba.core import types

    return types.ExternalFunctionPointer(_signature(callback.count), _ADDRESS)


def is_deferred() -> bool:
    """Return True if this thread compiles machine code: functions that kernels call are then compiled bare."""
    return getattr(_STATE, "deferred", False)


@contextmanager
def _deferred():
    """Let numba lower functions without optimising them, and without Python's collector, a seventh of the time."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    codegen = cpu_target.target_context.codegen()
    usual = codegen._library_class
    with global_compiler_lock:
        collecting = gc.isenabled()
        codegen._library_class, codegen.set_env = deferred_library(usual), lambda name, environment: None
        gc.disable()
        _STATE.deferred = True
        try:
            with slow_parts_replaced():
                yield
        finally:
            _STATE.deferred = False
            if collecting:
                gc.enable()
            codegen._library_class = usual
            del codegen.set_env


def deferred_library(usual):
    """Return a subclass of numba's class of code libraries that links but neither optimises nor emits machine code."""

    class Lowered(usual):
        def _optimize_functions(self, module):
            module.data_layout = self._codegen._data_layout

        def finalize(self):
            self._finalized = True

        def _get_module_for_linking(self):  # into a library of numba's own that wants the same function
            return _linked(self)

        def get_pointer_to_function(self, name):
            return 0

    return Lowered


def lowered(kernel, words, arguments, numba):
    """Return numba's code library of a kernel's entry, not optimised; the parameters are those of `machine_code`."""
    from numba.core import types

    given, words = [], iter(words)
    for k, (kind, argument) in enumerate(zip(kernel.types, arguments, strict=True)):
        given.append((f"given{k}", argument_type(kind, argument, words, numba)))
    table = _record()("Arguments", tuple(given))
    scope = {"opened": _opened(table), "kernel": kernel}
    source = (
        f"def entry(table):\n"
        f"    table = opened(table)\n"
        f"    answer = kernel({', '.join(f'table.{name}' for name, _ in given)})\n"
        f"    return 0 if answer is None else answer + 0\n"
    )
    exec(source, scope)
    signature = types.int64(types.CPointer(types.int64))
    return numba.cfunc(signature, pipeline_class=pipeline(), **BARE)(scope["entry"])._library


def argument_type(kind, argument, words, numba):
    """Return numba's type of an argument; of a named tuple that of the record which lies in the table."""
    if argument is None:
        return numba.none
    if hasattr(argument, "address"):  # a callback
        next(words)
        return pointer_type(argument)
    if hasattr(argument, "inner"):  # a kernel, such as a function of the law
        next(words)
        return numba.types.Dispatcher(argument.inner)
    if kind != "t":
        word = next(words)
        scalar = {"f": numba.float64, "i": numba.int64, "c": numba.complex128}[word[0]]
        return scalar if len(word) == 1 else numba.types.Array(scalar, int(word[1]), "C")
    return _record()(
        type(argument).__name__,
        tuple(
            (name, argument_type("t" if isinstance(field, tuple) else "", field, words, numba))
            for name, field in zip(argument._fields, argument, strict=True)
        ),
    )


@cache
def _record():
    """Return numba's type of a named tuple that lies in memory: a kernel reads a field where it needs it.

    Passed by value instead, every array of every tuple is seven numbers at every call: three times the code to compile.
    """
    from llvmlite import ir
    from numba.core import types
    from numba.core.typing.templates import AttributeTemplate
    from numba.extending import infer_getattr, lower_builtin, lower_getattr_generic, models, register_model

    word = ir.IntType(64)

    class Record(types.BaseTuple):
        def __init__(self, name, fields):
            self.fields, self.places, at = dict(fields), {}, 0  # `places`: the first word of each field
            self.types = tuple(self.fields.values())
            for field, kind in fields:
                self.places[field] = at
                at += _size(kind)
            self.size = at
            digest = hashlib.sha256(repr(fields).encode()).hexdigest()
            super().__init__(f"{name}{digest[:8]}")  # short, for it is part of the names of functions

        def __len__(self):
            return len(self.types)

    def _size(kind):
        if isinstance(kind, types.Array):
            return 1 + kind.ndim
        if isinstance(kind, types.Dispatcher):  # a function is known by its type
            return 0
        return kind.size if isinstance(kind, Record) else int(kind is not types.none)

    @register_model(Record)
    class _(models.PrimitiveModel):
        def __init__(self, manager, kind):
            super().__init__(manager, kind, word.as_pointer())

    @infer_getattr
    class _(AttributeTemplate):
        key = Record

        def generic_resolve(self, record, name):
            return record.fields.get(name)

    @lower_builtin("static_getitem", Record, types.IntegerLiteral)
    def _(context, builder, signature, arguments):
        record, (table, place) = signature.args[0], arguments
        return field(context, builder, record, table, list(record.fields)[place])

    @lower_getattr_generic(Record)
    def field(context, builder, record, table, name):
        kind, at = record.fields[name], record.places[name]

        def loaded(place, kind):
            address = builder.gep(table, [word(place)])
            value = builder.load(builder.bitcast(address, kind.as_pointer()))
            # nothing writes to the table: what is stored in arrays does not change it
            value.set_metadata("invariant.load", builder.module.add_metadata([]))
            return value

        if isinstance(kind, Record):
            return builder.gep(table, [word(at)])
        if kind is types.none or isinstance(kind, types.Dispatcher):
            return context.get_dummy_value()
        if not isinstance(kind, types.Array):
            return loaded(at, context.get_value_type(kind))
        # numba's own structure of an array with contiguous data, from the address and the lengths
        model = context.data_model_manager[kind]
        value = ir.Constant(model.get_value_type(), None)
        size, count = word(context.get_abi_sizeof(context.get_data_type(kind.dtype))), word(1)
        stride, lengths = size, [loaded(at + 1 + axis, word) for axis in range(kind.ndim)]
        for axis in reversed(range(kind.ndim)):
            value = builder.insert_value(value, lengths[axis], [model.get_field_position("shape"), axis])
            value = builder.insert_value(value, stride, [model.get_field_position("strides"), axis])
            stride, count = builder.mul(stride, lengths[axis]), builder.mul(count, lengths[axis])
        data = loaded(at, context.get_data_type(kind.dtype).as_pointer())
        for part, number in (("data", data), ("itemsize", size), ("nitems", count)):
            value = builder.insert_value(value, number, [model.get_field_position(part)])
        return value

    return Record


def _opened(record):
    """Return a function for kernels that takes the address of a record for the record."""
    from numba.extending import intrinsic

    @intrinsic
    def opened(context, address):
        return record(address), lambda context, builder, signature, arguments: arguments[0]

    return opened


def _linked(library):
    """Return one module of a library's functions and of all that they call."""
    libraries = [library]
    for each in libraries:
        libraries += [other for other in dict.fromkeys(each._linking_libraries) if other not in libraries]
    modules = [each._final_module.clone() for each in libraries]
    for module in modules:
        _set_linkage(module, "weak_odr")  # kept in what it is linked into, referred to or not
    # in pairs, for LLVM goes through all types of a module that another is linked into
    while len(modules) > 1:
        for module, other in zip(modules[::2], modules[1::2], strict=False):
            module.link_in(other)
        modules = modules[::2]
    _set_linkage(modules[0], "linkonce_odr")
    return modules[0]


def _set_linkage(module, linkage):
    """Set the linkage of all functions that a module defines."""
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = linkage


def optimised(library, *, wrapper=False):
    """Return the object file of the library's entry, or of the C function that wraps it."""
    import llvmlite.binding as llvm

    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=3, codemodel="jitdefault",
        jit=True,
    )  # fmt: skip
    module = _linked(library)
    entry = next(
        f.name
        for f in module.functions
        if not f.is_declaration and f.name.startswith("cfunc.") == wrapper and (wrapper or "entry" in f.name)
    )
    _set_linkage(module, "internal")
    function = module.get_function(entry)
    function.linkage, function.name = "external", "kernel"
    dead = llvm.create_new_module_pass_manager()
    dead.add_global_dead_code_eliminate_pass()
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    passes = llvm.create_pass_builder(machine, tuning)
    dead.run(module, passes)
    passes.getModulePassManager().run(module, passes)
    strange = [f.name for f in module.functions if f.is_declaration and not _LIBRARY.fullmatch(f.name)]
    if strange:
        raise RuntimeError(f"a native kernel may not allocate or raise, but calls {', '.join(strange)}")
    return machine.emit_object(module)


def without_failing_cache(dispatcher):
    """Let a dispatcher compile where its cache cannot be read or written: a full disk, no memory left, a spent index.

    Numba raises the error of the disk out of the call that has compiled, and a `ReferenceError` where its index holds
    more types of functions than it remembers.
    """
    kept = getattr(dispatcher, "_cache", None)
    for name in ("load_overload", "save_overload"):
        plain = getattr(kept, name, None)
        if plain is not None:
            setattr(kept, name, _forgiving(plain))


def _forgiving(operation):
    def tried(*arguments):
        try:
            return operation(*arguments)
        except (OSError, MemoryError, ReferenceError):
            return None

    return tried
