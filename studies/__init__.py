"""Measured comparisons: one file a study, `python -m studies list` shows them."""

from importlib.util import find_spec

_LIBRARIES = ("matplotlib", "tqdm")

if missing := [name for name in _LIBRARIES if find_spec(name) is None]:
    raise ImportError(
        f"studies need {' and '.join(missing)}, not installed here: pip install 'exudyn_inext[studies]'."
    )
