"""numba's compiler without what our kernels do not need."""

import gc
from functools import cache
from typing import Any

from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.typed_passes import InlineOverloads, NopythonRewrites
from numba.core.untyped_passes import (
    InlineClosureLikes,
    LiteralPropagationSubPipelinePass,
)

# for expressions of whole arrays, functions within functions and loops over tuples
NOT_NEEDED = (
    InlineClosureLikes,
    InlineOverloads,
    LiteralPropagationSubPipelinePass,
    NopythonRewrites,
)


class QuickFlags(Flags):
    """numba's flags, compared by those that are set: numba asks for each of forty
    options on both sides, two hundred thousand times."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flags):
            return NotImplemented
        if self._values == other._values:
            return True
        names = {**self._values, **other._values}
        return all(getattr(self, n) == getattr(other, n) for n in names)

    def __hash__(self) -> int:
        return NAMES  # numba hashes the options' names alone


NAMES = hash(Flags())


class QuickTyping:
    """numba's context of types, which asks once what an operation on numbers gives:
    numba tries up to forty overloads for each."""

    def __init__(self, own: Any) -> None:
        self.own = own

    def __getattr__(self, name: str) -> Any:
        return getattr(self.own, name)

    def resolve_function_type(self, function: Any, args: tuple, named: dict) -> Any:
        """As numba's."""
        numbers = all(isinstance(a, types.Number | types.Boolean) for a in args)
        if named or not numbers or not isinstance(function, types.Function):
            return self.own.resolve_function_type(function, args, named)
        return _of_numbers(self.own, function, args)


@cache
def _of_numbers(own: Any, function: Any, args: tuple) -> Any:
    return own.resolve_function_type(function, args, {})


class WholeLibrary(JITCodeLibrary):
    """Code of a kernel, which is optimised with all its parts in it: before, each part
    by itself has been."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout


class QuickCompiler(Compiler):
    """numba's own, quicker."""

    def __init__(self, typing, target, library, args, returned, flags, local):
        quick = QuickTyping(typing), target, library, args, returned, QuickFlags(flags)
        super().__init__(*quick, local)

    def define_pipelines(self) -> list:
        """As numba's."""
        (manager,) = super().define_pipelines()
        manager.passes = [p for p in manager.passes if p[0] not in NOT_NEEDED]
        manager.finalize()
        return [manager]

    def compile_extra(self, func: Any) -> Any:
        """As numba's, while nothing is searched for garbage."""
        state, collects = self.state, gc.isenabled()
        if not state.flags.no_cpython_wrapper:
            state.library = WholeLibrary(state.targetctx.codegen(), func.__qualname__)
            state.library.enable_object_caching()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if collects:
                gc.enable()
