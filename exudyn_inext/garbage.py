"""Python's search for garbage, which looks at all that lives each time that much has been made."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def not_collected() -> Iterator[None]:
    """Meanwhile, garbage is not searched for: what is made at once, and kept, is no garbage."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
