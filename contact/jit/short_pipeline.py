"""Numba's compiler as kernels need it: without the passes for what no kernel has, and with slow parts replaced.

To lower the kernels of a first run, numba's own pipeline takes half as long again. Left out are the passes for
closures, `with`, literals that are asked for, expressions of whole arrays and the drawing of types, and what counts
references: kernels allocate nothing. Everything here is for the time in which `contact.jit.compiler` has numba lower a
kernel; whatever else numba compiles in this process, it compiles as usual.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from operator import attrgetter
from typing import Any


@cache
def pipeline():
    """Return the subclass of numba's compiler that has the passes which kernels need, in numba's order."""
    from numba.core import ir_utils, postproc, typed_passes, untyped_passes
    from numba.core.compiler import CompilerBase
    from numba.core.compiler_machinery import AnalysisPass, PassManager, register_pass

    @register_pass(mutates_CFG=False, analysis_only=True)
    class Legalization(AnalysisPass):
        """As numba's own, without marking where variables end, which only counts of references need."""

        _name = "legalization_without_ends"

        def __init__(self):
            AnalysisPass.__init__(self)

        def run_pass(self, state):
            ir_utils.enforce_no_phis(state.func_ir)
            postproc.PostProcessor(state.func_ir).run(emit_dels=False)
            return True

    passes = (
        untyped_passes.TranslateByteCode, untyped_passes.FixupArgs, untyped_passes.IRProcessing,
        untyped_passes.RewriteSemanticConstants, untyped_passes.DeadBranchPrune, untyped_passes.GenericRewrites,
        untyped_passes.ReconstructSSA, untyped_passes.DeadBranchPrune, typed_passes.NopythonTypeInference,
        typed_passes.PreLowerStripPhis, Legalization, typed_passes.NativeLowering, typed_passes.NoPythonBackend,
    )  # fmt: skip

    class KernelCompiler(CompilerBase):
        def define_pipelines(self):
            manager = PassManager("kernels")
            for each in passes:
                manager.add_pass(each, each.__name__)
            manager.finalize()
            return [manager]

    return KernelCompiler


@contextmanager
def slow_parts_replaced() -> Iterator[None]:
    """Replace functions of numba by faster ones that return the same; the caller holds numba's compiler lock."""
    replaced = (*_in_typing(), *_in_lowering())
    usual = [vars(owner)[name] for owner, name, _ in replaced]
    try:
        for owner, name, function in replaced:
            setattr(owner, name, function)
        yield
    finally:
        for (owner, name, _), function in zip(replaced, usual, strict=True):
            setattr(owner, name, function)


def _in_typing() -> tuple[tuple[Any, str, Callable], ...]:
    """Return (owner, name, replacement) of slow functions of numba's analysis and of its types."""
    from numba.core import ir, types
    from numba.core.targetconfig import TargetConfig
    from numba.core.types.functions import BaseFunction

    typed, equal, hashed = BaseFunction.get_call_type, TargetConfig.__eq__, TargetConfig.__hash__
    numbers, known, hashes, set_in = (types.Number, types.Boolean), {}, {}, attrgetter("_values")
    # by type, whether a value is a variable, an instruction or a container: these classes of numba are abstract ones,
    # of which `isinstance` is slow
    kinds: dict[type, type | None] = {}

    def kind_of(value):
        classes = ir.Var, ir.Inst, dict, list, tuple
        return next((each for each in classes if isinstance(value, each)), None)

    def list_variables(instruction, value):
        variables, values = [], [value]
        while values:
            each = values.pop()
            sort = type(each)
            if sort not in kinds:
                kinds[sort] = kind_of(each)
            kind = kinds[sort]
            if kind is None:
                continue
            if kind is ir.Var:
                variables.append(each)
            elif kind is ir.Inst:
                variables += each.list_vars()
            else:
                values += each.values() if kind is dict else each
        return variables

    def type_of_call(function, context, arguments, keywords):
        if keywords or not all([isinstance(each, numbers) for each in arguments]):
            return typed(function, context, arguments, keywords)
        call = id(function), tuple(arguments)
        if call not in known:
            known[call] = typed(function, context, arguments, keywords), function  # which keeps its number meanwhile
        return known[call][0]

    def same_options(options, other):
        if options is other or (type(options) is type(other) and set_in(options) == set_in(other)):
            return True
        return equal(options, other)

    def hash_of_options(options):
        # numba hashes the names of the options alone
        if type(options) not in hashes:
            hashes[type(options)] = hashed(options)
        return hashes[type(options)]

    return (
        (ir.Inst, "_rec_list_vars", list_variables),
        (BaseFunction, "get_call_type", type_of_call),
        (TargetConfig, "__eq__", same_options),
        (TargetConfig, "__hash__", hash_of_options),
    )


def _in_lowering() -> tuple[tuple[Any, str, Callable], ...]:
    """Return (owner, name, replacement) of slow functions that numba calls while it writes LLVM's code."""
    from llvmlite.ir.types import IdentifiedStructType, Type
    from numba.core import event
    from numba.core.base import BaseContext

    measured, refreshed = Type.get_abi_size, BaseContext.refresh
    sizes: dict[tuple, int] = {}
    registrations: dict[int, int] = {}
    registries = attrgetter("_registries")

    def size_of_type(kind, target_data, context=None):
        # LLVM reads a module of text for each size
        if isinstance(kind, IdentifiedStructType):  # of which the text is but a name
            return measured(kind, target_data, context)
        key = str(kind), target_data
        if key not in sizes:
            sizes[key] = measured(kind, target_data, context)
        return sizes[key]

    def count(context):
        loaders = [*registries(context).items(), *registries(context.typing_context).items()]
        return sum([len(getattr(registry, name)) for registry, loader in loaders for name in loader.registry_items])

    def refresh(context):
        # asked for at each function that is not there, such as one that few types have
        if registrations.get(id(context)) != count(context):
            refreshed(context)
            registrations[id(context)] = count(context)

    def not_told(kind, data=None, exc_details=None):
        """Trigger no event: only timers that nobody reads listen, and more of them the deeper functions are nested."""

    return (
        (Type, "get_abi_size", size_of_type),
        (BaseContext, "refresh", refresh),
        (event, "start_event", not_told),
        (event, "end_event", not_told),
    )
