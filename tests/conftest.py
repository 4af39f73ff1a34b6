"""Properties are tried on the same examples in every run, without a time limit; failures are not stored.

CPU clocks jump, as on a machine with neighbours: no test may depend on what something takes. Linear algebra
has one thread in each process: those of several processes would spin while they wait for each other.

Known answers and faults are recorded as properties of their tests, for the table of `tests.verification`.

Fixtures import what they patch: the process that only hands tests out begins 2 s sooner.
"""

import gc
import os
import random
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is loaded

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, max_examples=20, deadline=None, database=None)
settings.load_profile("repeatable")


def pytest_collection_modifyitems(items):
    """Processes that run halves of the list begin with other kernels, and find the rest in the cache.

    One begins with scenes, whose kinds share most of their parts: who has compiled one has half of the next.
    One begins with lone cables, in space and then in the plane, which share none.
    """
    groups = {name: [] for name in ("scenes", "plane", "cables", "space", "others")}
    for item in items:
        groups[group_of(item)].append(item)
    scenes, in_plane, cables, in_space, others = groups.values()
    scenes.sort(key=lambda item: dimension_of(item) or 4)
    cables.sort(key=lambda item: -(dimension_of(item) or 0))
    place = max(0, len(items) // 2 - len(scenes) - len(in_plane))
    items[:] = [*scenes, *in_plane, *others[:place], *cables, *in_space, *others[place:]]


def pytest_collection_finish():
    """What is imported and collected stays; garbage is not looked for among it again and again."""
    gc.collect()
    gc.freeze()


def group_of(item):
    """By the kernels that a test compiles, which its folder and its dimension tell."""
    folders = {"native": "scenes", "cable": "cables", "element": "cables"}
    dimensions = {2: "plane", 3: "space"}
    return folders.get(item.path.parent.name) or dimensions.get(dimension_of(item), "others")


def dimension_of(item):
    """2, 3, or None where a test has no such parameter."""
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    return parameters.get("dim", parameters.get("dimension"))


@pytest.fixture(autouse=True)
def a_clock_that_jumps(monkeypatch):
    """One reading in three of the CPU clock comes up to 0.3 s later than it should."""
    clock, chance = time.process_time, random.Random(1)
    late = 0.0

    def jumping():
        nonlocal late
        if chance.random() < 1.0 / 3.0:
            late += chance.uniform(0.0, 0.3)
        return clock() + late

    monkeypatch.setattr(time, "process_time", jumping)


@pytest.fixture
def by_exudyn(monkeypatch):
    """Exudyn evaluates its items, although they have compiled forms."""
    from exudyn_inext.native.coupled_scene import CoupledScene

    monkeypatch.setattr(CoupledScene, "compiled", lambda *_: (None, "this test"))
    monkeypatch.setattr(CoupledScene, "compile_parts", lambda *_: None)


@pytest.fixture
def known_answer(record_property):
    """(what, relative error, observed order): an answer that was known, and how well it was found."""

    def record(what, error, order=None):
        record_property("known answer", f"{what}|{error:.1e}|{'' if order is None else f'{order:.2f}'}")

    return record


@pytest.fixture
def fault(record_property):
    """(what, what came of it): something that went wrong, and was survived."""
    return lambda what, outcome: record_property("fault", f"{what}|{outcome}")


def axes_without_units(figure):
    """(title, axis, labels) where quantity and [unit] are missing; axes that share one share its label."""
    from matplotlib.ticker import FixedLocator

    missing = []
    for axes in figure.axes:
        for name in axes._axis_names if axes.axison else ():
            shared = axes._shared_axes[name].get_siblings(axes)
            labels = [getattr(other, f"get_{name}label")() for other in shared]
            axis = getattr(axes, f"{name}axis")
            names_cases = axis.have_units() or isinstance(axis.get_major_locator(), FixedLocator)  # words
            if not names_cases and not any("[" in label and label.endswith("]") for label in labels):
                missing.append((axes.get_title(loc="left"), name, labels))
    return missing


@pytest.fixture(autouse=True, scope="session")
def every_picture_that_is_saved_has_units_at_its_axes():
    from matplotlib.figure import Figure

    save = Figure.savefig

    def checked(figure, *arguments, **options):
        assert axes_without_units(figure) == []
        return save(figure, *arguments, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", checked)
        yield
