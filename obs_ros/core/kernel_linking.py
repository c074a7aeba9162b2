"""What stored code has to know of a process that loads it, and what Numba need not keep of it."""

from typing import Any


def symbols(compiled: Any) -> list[str]:
    """Return the names of all that a compiled function calls, and that is not part of it."""
    module = compiled.library._final_module
    parts = (*module.functions, *module.global_variables)
    return sorted(
        part.name for part in parts if part.is_declaration and not part.name.startswith('llvm.')
    )


def make_known(called: list[str], target: Any) -> None:
    """Let a Numba target know these names: what LLVM meets unknown ends the process.

    Few ask for more than memory. All that Numba can compile, which it takes a third of a second to
    import, is only loaded for those that do.
    """
    from llvmlite.binding import address_of_symbol  # type: ignore[import-untyped]
    from numba.core.runtime.nrt import rtsys

    rtsys.initialize(target)
    if not all(map(address_of_symbol, called)):
        target.refresh()


def let_go(library: Any, code: tuple[str, str, tuple[bytes, bytes]]) -> None:
    """Free the parsed intermediate code of a library that was loaded, some 0.4 MB each.

    Only functions that are compiled here and call it need that: for each it is parsed anew.
    """
    from llvmlite.binding import parse_bitcode

    _, _, (_, bitcode) = code
    library._shared_module = None
    library._get_module_for_linking = lambda: parse_bitcode(bitcode)
