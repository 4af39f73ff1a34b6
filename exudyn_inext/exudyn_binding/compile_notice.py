"""A line on the console that kernels are compiled, which only the first run of a kind does."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .. import compiled
from ..lowered import Compilation


@contextmanager
def compile_notice(settings: Any) -> Iterator[None]:
    """Before the first kernel that is compiled within, and how long it took; unless verboseMode is 0."""
    if settings.timeIntegration.verboseMode == 0:
        yield
        return
    compilation = Compilation(_announce)
    try:
        with compilation.listening():
            yield
    finally:
        if compilation.seconds:
            print(f"exudyn_inext: kernels compiled in {compilation.seconds:.1f} s", flush=True)


def _announce() -> None:
    folder = compiled.CACHE_FOLDER
    kept = f"once: they are kept in {folder}" if folder else "in each process: no cache can be written to"
    print(f"exudyn_inext: compiling kernels, which takes some 15 s, {kept}", flush=True)
