"""The cache of compiled kernels on disk, shared by processes that run at once."""

import re

import exudyn
import numba
import pytest

from exudyn_inext import ExplicitSettings, ExplicitStepper, SolveEnsemble, compiled
from exudyn_inext.exudyn_binding.console import compile_notice
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_pendulum, load_node

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


def half(x):
    return x / 2


@pytest.fixture
def process(monkeypatch, tmp_path):
    """A kernel of its own for each process that would compile `half`; they share one cache."""
    monkeypatch.setattr(compiled, "CACHE_FOLDER", tmp_path)
    return lambda: compiled.kernel(half)


def test_a_kernel_is_compiled_once_for_all_processes(process):
    first, later = process(), process()
    assert first(3.0) == later(3.0) == 1.5
    assert later.nopython_signatures == first.nopython_signatures
    assert sum(later.stats.cache_hits.values()) == 1


def test_processes_that_compile_at_once_do_not_get_each_others_code(process, monkeypatch):
    """The second one has seen an empty cache, and saves while the first one is saving."""
    first, second = process(), process()
    mine, others = first._cache._cache_file, second._cache._cache_file
    monkeypatch.setattr(others, "_load_index", lambda: {})
    write = mine._save_data

    def interrupted(name, data):
        second(1 + 2j)
        write(name, data)

    monkeypatch.setattr(mine, "_save_data", interrupted)
    assert first(3.0) == 1.5
    later = process()
    assert later(1 + 2j) == 0.5 + 1j
    assert later(3.0) == 1.5


part_of_it = compiled.inlined_kernel(lambda x: x + 1.0)


@compiled.kernel
def whole(x):
    return 2.0 * part_of_it(x)


def test_in_python_nothing_is_compiled():
    assert compiled.in_python(whole)(3.0) == 8.0
    assert not whole.signatures and not part_of_it.signatures


KNOWN = ExplicitSettings(stepSize=1e-3, dependsOnTimeOnly=True)


def stepped(mbs):
    stepper = ExplicitStepper(mbs, KNOWN)
    stepper.Start()
    stepper.Step()


def in_an_ensemble(mbs):
    SolveEnsemble([mbs], quiet_settings(0.01, 10), KNOWN, threads=1)


@pytest.mark.parametrize("folder", [True, False])
@pytest.mark.parametrize("verbose", [0, 1])
def test_a_run_says_once_that_kernels_are_compiled(process, capsys, monkeypatch, folder, verbose):
    monkeypatch.setattr(compiled, "CACHE_FOLDER", compiled.CACHE_FOLDER if folder else None)
    settings = quiet_settings(1.0, 1)
    settings.timeIntegration.verboseMode = verbose
    first, second = compiled.kernel(half), compiled.kernel(third)
    with compile_notice(settings):
        first(3.0)
        second(3.0)
    ended, begun = capsys.readouterr()
    place = f"once: they are kept in {compiled.CACHE_FOLDER}" if folder else "in each process"
    assert len(begun.splitlines()) == 1 and "compiling kernels" in begun and place in begun
    assert len(ended.splitlines()) == verbose
    if verbose:
        assert float(re.search(r"compiled in (\S+) s", ended)[1]) >= 0.0
    with compile_notice(settings):
        first(3.0)
    assert capsys.readouterr() == ("", "")


def test_no_line_where_exudyn_is_silent(process, capsys):
    with silence(), compile_notice(quiet_settings(1.0, 1)):
        process()(3.0)
    assert capsys.readouterr() == ("", "")


def test_exudyns_clock_stands_still_while_kernels_are_compiled(process):
    solver = exudyn.MainSolverImplicitSecondOrder()
    with compile_notice(quiet_settings(1.0, 1), solver), silence():
        process()(3.0)
    assert 0.0 < solver.output.cpuSolverStartTime < 60.0


@pytest.mark.parametrize("solve", [stepped, in_an_ensemble], ids=lambda solve: solve.__name__)
def test_steppers_and_ensembles_say_so_too(process, capsys, solve):
    """The first kernel that is compiled within them is a user's."""
    new = process()

    def force(mbs, t, load):
        return [new(t), 0.0, 0.0]

    exudyn.config.printToConsole = True
    mbs = exudyn.SystemContainer().AddSystem()
    load_node(mbs, add_pendulum(mbs)["nodes"][-1], [0, 0, 0], loadVectorUserFunction=force)
    mbs.Assemble()
    solve(mbs)
    assert "compiling kernels" in capsys.readouterr().err


def third(x):
    return x / 3
