"""Numba's compiler as kernels need it: without the passes for what no kernel has, and with three slow parts replaced.

To lower the kernels of a first run, numba's own pipeline takes half as long again. Left out are the passes for
closures, `with`, literals that are asked for, expressions of whole arrays and the drawing of types, and what counts
references: kernels allocate nothing. Everything here is for the time in which `contact.jit.compiler` has numba lower a
kernel; whatever else numba compiles in this process, it compiles as usual.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache


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
    """Replace two functions of numba by faster ones that return the same; the caller holds numba's compiler lock."""
    from numba.core import ir, types
    from numba.core.types.functions import BaseFunction

    typed = BaseFunction.get_call_type
    unlisted, numbers, known = (str, int, float, ir.Loc, type(None)), (types.Number, types.Boolean), {}

    def list_variables(instruction, value):
        variables, values = [], [value]
        while values:
            each = values.pop()
            if isinstance(each, ir.Var):
                variables.append(each)
            elif isinstance(each, unlisted):
                continue
            elif isinstance(each, ir.Inst):
                variables += each.list_vars()
            elif isinstance(each, dict):
                values += each.values()
            elif isinstance(each, list | tuple):
                values += each
        return variables

    def type_of_call(function, context, arguments, keywords):
        if keywords or not all([isinstance(each, numbers) for each in arguments]):
            return typed(function, context, arguments, keywords)
        call = id(function), tuple(arguments)
        if call not in known:
            known[call] = typed(function, context, arguments, keywords), function  # which keeps its number meanwhile
        return known[call][0]

    replaced: tuple[tuple[type, str, Callable], ...] = (
        (ir.Inst, "_rec_list_vars", list_variables),
        (BaseFunction, "get_call_type", type_of_call),
    )
    usual = [vars(owner)[name] for owner, name, _ in replaced]
    try:
        for owner, name, function in replaced:
            setattr(owner, name, function)
        yield
    finally:
        for (owner, name, _), function in zip(replaced, usual, strict=True):
            setattr(owner, name, function)
