"""The cache of compiled kernels on disk, shared by processes that run at once."""

import numba
import pytest

from exudyn_inext import compiled

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
