"""The cache of compiled kernels on disk, shared by processes that run at once."""

import re

import numba
import pytest

from exudyn_inext import compiled
from exudyn_inext.exudyn_binding.compile_notice import compile_notice
from reference_models.model import quiet_settings

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


def half(x):
    return x / 2


@pytest.fixture
def process(monkeypatch, tmp_path):
    """A kernel of its own for each process that would compile `half`; they share one cache."""
    monkeypatch.setattr(compiled, "CACHE_FOLDER", tmp_path)
    return lambda: compiled.kernel(half)


def test_a_kernel_is_compiled_once_for_all_processes(process):
    assert process()(3.0) == 1.5
    later = process()
    assert later(3.0) == 1.5
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


@pytest.mark.parametrize("folder", [True, False])
def test_a_run_says_once_that_kernels_are_compiled_and_how_long_it_took(process, capsys, monkeypatch, folder):
    monkeypatch.setattr(compiled, "CACHE_FOLDER", compiled.CACHE_FOLDER if folder else None)
    settings = quiet_settings(1.0, 1)
    for verbose, lines in ((1, 2), (0, 0)):
        settings.timeIntegration.verboseMode = verbose
        first, second = compiled.kernel(half), compiled.kernel(third)
        with compile_notice(settings):
            first(3.0)
            second(3.0)
        said = capsys.readouterr().out.splitlines()
        assert len(said) == lines
        if verbose:
            place = f"once: they are kept in {compiled.CACHE_FOLDER}" if folder else "in each process"
            assert "compiling kernels" in said[0] and place in said[0]
            assert float(re.search(r"compiled in (\S+) s", said[1])[1]) >= 0.0
            with compile_notice(settings):
                first(3.0)
            assert not capsys.readouterr().out


def third(x):
    return x / 3
