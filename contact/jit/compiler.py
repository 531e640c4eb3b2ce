"""Machine code of a kernel that stands alone: numba types and lowers it, llvmlite optimises it once and for all.

Numba would optimise every function by itself and again inside each that calls it, and wrap each for Python.  Here that
is put off: one module, one entry, everything inlined that pays.  The entry takes a table of 64-bit words (addresses,
lengths, numbers).  Reference counts are left out, for nothing is allocated.
"""

import re

# what a kernel may call beyond itself: the C library's mathematics
_LIBRARY = re.compile(
    r"llvm\..*|sin|cos|tan|sqrt|asin|acos|atan|atan2|hypot|pow|exp|log|floor|ceil|fmod|cbrt|mem(set|cpy|move)|__\w+c3"
)
_COUNTING = re.compile(r"^define [^\n]*@NRT_(in|de)cref\([^{]*\{.*?^\}", re.MULTILINE | re.DOTALL)


def machine_code(kernel, words: list[str], arguments: tuple, numba) -> bytes:
    """Return the object file of a kernel for arguments of these type words, its entry named `kernel`.

    `arguments`: an example, for the classes of the named tuples among them.
    """
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    codegen = cpu_target.target_context.codegen()
    usual = codegen._library_class
    with global_compiler_lock:
        codegen._library_class, codegen.set_env = _put_off(usual), lambda name, environment: None
        try:
            library = _lowered(kernel, words, arguments, numba)
        finally:
            codegen._library_class = usual
            del codegen.set_env
    return _optimised(library)


def _put_off(usual):
    """Return numba's class of code libraries, made to link but neither to optimise nor to emit anything."""

    class Lowered(usual):
        def _optimize_functions(self, module):
            module.data_layout = self._codegen._data_layout

        def _optimize_final_module(self):
            pass

        def _finalize_final_module(self):
            self._finalize_dynamic_globals()
            self._finalized = True

        def get_pointer_to_function(self, name):
            self._ensure_finalized()
            return 0

    return Lowered


def _lowered(kernel, words, arguments, numba):
    """Return numba's code library of the entry, not optimised."""
    from numba.core import cgutils, types
    from numba.extending import intrinsic

    @intrinsic
    def pointer(context, address):
        def lowered(context, builder, signature, arguments):
            return builder.inttoptr(arguments[0], cgutils.voidptr_t)

        return types.voidptr(types.int64), lowered

    scope = {"carray": numba.carray, "pointer": pointer, "kernel": kernel}
    scope |= {"f": numba.float64, "i": numba.int64, "c": numba.complex128}
    given, at = [], 0
    for word in words:
        if len(word) == 1:
            given.append(f"{'numbers' if word == 'f' else 'words'}[{at}]")
            at += 1
        else:
            axes = int(word[1])
            shape = "".join(f"words[{at + 1 + k}], " for k in range(axes))
            given.append(f"carray(pointer(words[{at}]), ({shape}), {word[0]})")
            at += 1 + axes
    parts = iter(given)
    given = [
        _gathered(kind, argument, parts, scope)
        for kind, argument in zip(kernel.types, arguments, strict=True)
    ]
    source = (
        f"def entry(words, numbers):\n"
        f"    words, numbers = carray(words, ({at},)), carray(numbers, ({at},))\n"
        f"    answer = kernel({', '.join(given)})\n"
        f"    return 0 if answer is None else answer + 0\n"
    )
    exec(source, scope)
    words_type, numbers_type = types.CPointer(types.int64), types.CPointer(types.float64)
    function = numba.cfunc(types.int64(words_type, numbers_type), error_model="numpy")(scope["entry"])
    return function._library


def _gathered(kind, argument, parts, scope):
    """Return the source of one argument, a named tuple made of the parts that are its fields."""
    if kind != "t":
        return next(parts)
    if argument is None:
        return "None"
    name = f"{type(argument).__name__}{len(scope)}"
    scope[name] = type(argument)
    fields = [
        _gathered("t" if field is None or isinstance(field, tuple) else "", field, parts, scope)
        for field in argument
    ]
    return f"{name}({', '.join(fields)})"


def _optimised(library):
    """Return the object file of the library's entry."""
    import llvmlite.binding as llvm

    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=3, codemodel="jitdefault",
        jit=True,
    )  # fmt: skip
    text = _COUNTING.sub("", str(library._final_module))
    for name in ("incref", "decref"):
        text = re.sub(rf"^declare [^\n]*@NRT_{name}\([^\n]*$", "", text, flags=re.MULTILINE)
        text += f"\ndefine internal void @NRT_{name}(ptr %0) alwaysinline {{\n  ret void\n}}\n"
    module = llvm.parse_assembly(text)
    entry = next(
        f.name
        for f in module.functions
        if not f.is_declaration and "entry" in f.name and not f.name.startswith("cfunc.")
    )
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "internal"
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
