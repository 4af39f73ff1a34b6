"""python -m tests.mutation: mutants of `element/` and `cable/`, and whether the tests notice them.

Cosmic Ray (https://cosmic-ray.readthedocs.io) makes the mutants. Each is written into a copy of the project
and tested, without the compiler, in a process that is forked once the libraries are loaded. So many of each
module are drawn with a seed. Not a part of the test suite: needs `pip install cosmic-ray`, and POSIX.
"""

# ruff: noqa: E402

import argparse
import difflib
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

os.environ["NUMBA_DISABLE_JIT"] = "1"
os.environ.pop("NUMBA_CACHE_DIR", None)  # the mutants would remove it
sys.dont_write_bytecode = True

# Loaded once, before the forks.
import exudyn  # noqa: F401
import hypothesis  # noqa: F401
import numba  # noqa: F401
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
import scipy.sparse.linalg  # noqa: F401
from cosmic_ray.commands.init import init
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from cosmic_ray.work_db import use_db
from cosmic_ray.work_item import MutationSpec
from tqdm import tqdm

from .equivalent import why_equivalent
from .plan import OPERATORS, SLOW, tests_of

PROJECT = Path(__file__).parents[2]
COPIED = ("exudyn_inext", "tests", "reference_models", "pyproject.toml")
FOLDERS = ("element", "chain")
KILLED, SURVIVED, EQUIVALENT = "killed", "survived", "equivalent"
PYTEST = ["-x", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "-m", "kernel"]
PYTEST += [
    "-k",
    f"not ({SLOW})",
    "-o",
    "addopts=--import-mode=importlib",
    "-W",
    "ignore::pytest.PytestAssertRewriteWarning",
]


@contextmanager
def copy_of_project() -> Iterator[Path]:
    """A copy in a folder of its own, which is the working directory."""
    with tempfile.TemporaryDirectory() as folder:
        for name in COPIED:
            source = PROJECT / name
            if source.is_dir():
                shutil.copytree(source, Path(folder, name), ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, folder)
        os.chdir(folder)
        sys.path[:] = [folder, *(path for path in sys.path if path not in ("", str(PROJECT)))]
        sys.modules.pop("tests")
        yield Path(folder)


def drawn_mutants(modules: list[Path], share: float, seed: int) -> list[MutationSpec]:
    """That share of the mutants of each module, at least ten."""
    with use_db("session.sqlite") as database:
        init(modules, database, {})
        all_mutants = [m for item in database.work_items for m in item.mutations]
    drawn = []
    for module in modules:
        of_module = [m for m in all_mutants if m.module_path == module and m.operator_name in OPERATORS]
        of_module.sort(key=lambda m: (m.start_pos, m.operator_name, m.occurrence))
        number = min(len(of_module), max(10, round(share * len(of_module))))
        drawn += random.Random(f"{seed} {module.name}").sample(of_module, number)
    return drawn


def _key(mutant: MutationSpec) -> str:
    module = Path(mutant.module_path).relative_to("exudyn_inext").as_posix()
    return json.dumps([module, mutant.operator_name, mutant.operator_args, mutant.occurrence])


def settled_before(files: list[Path]) -> dict[str, dict[str, Any]]:
    """Mutants that former runs have killed -> what is known of them."""
    lines = [line for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    killed = [result for result in map(json.loads, lines) if result["outcome"] == KILLED]
    return {json.dumps([result["module"], *result["mutant"]]): result for result in killed}


def passes(tests: list[str], limit: float, log: Path) -> bool:
    """Whether the tests pass within `limit` seconds, in a process of their own."""
    child = os.fork()
    if child == 0:
        os.setsid()
        descriptor = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        os._exit(pytest.main([*PYTEST, *tests]))
    end = time.monotonic() + limit
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) == 0
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def try_mutant(mutant: MutationSpec, limit: float) -> dict[str, Any]:
    """What became of a mutant, and what it was."""
    path = Path(mutant.module_path)
    code = path.read_text(encoding="utf-8")
    operator = get_operator(mutant.operator_name)(**mutant.operator_args)
    changed = mutate_code(code, operator, mutant.occurrence)
    lines = list(difflib.unified_diff(code.splitlines(), changed.splitlines(), n=0, lineterm=""))[2:]
    result: dict[str, Any] = {
        "mutant": [mutant.operator_name, mutant.operator_args, mutant.occurrence],
        "module": path.relative_to("exudyn_inext").as_posix(),
        "line": mutant.start_pos[0],
        "was": " ".join(line[1:].strip() for line in lines if line[0] == "-"),
        "became": " ".join(line[1:].strip() for line in lines if line[0] == "+"),
    }
    result["reason"] = why_equivalent(result["module"], result["was"], result["became"])
    if result["reason"]:
        return result | {"outcome": EQUIVALENT}
    start = time.monotonic()
    path.write_text(changed, encoding="utf-8")
    survived = passes(tests_of(path.name), limit, Path("log.txt"))
    path.write_text(code, encoding="utf-8")
    return result | {
        "outcome": SURVIVED if survived else KILLED,
        "seconds": round(time.monotonic() - start, 1),
    }


def table(results: list[dict[str, Any]]) -> str:
    """Markdown: one row a module."""
    lines = ["| module | mutants | killed | survived | equivalent |", "| --- | ---: | ---: | ---: | ---: |"]
    modules = sorted({r["module"] for r in results}, reverse=True)
    for module in [*modules, "all"]:
        count = Counter(r["outcome"] for r in results if module in (r["module"], "all"))
        numbers = (count.total(), *(count[outcome] for outcome in (KILLED, SURVIVED, EQUIVALENT)))
        lines.append(f"| `{module}` | " + " | ".join(map(str, numbers)) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument(
        "--share", type=float, default=0.2, help="of the mutants of each module (default: 0.2)"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for the tests of one mutant")
    parser.add_argument("--modules", nargs="*", default=[], help="names, e.g. drag; default: all")
    parser.add_argument(
        "--again", type=Path, nargs="*", help="results of former runs: what they killed is done"
    )
    parser.add_argument("--output", type=Path, default=Path("results"))
    options = parser.parse_args()
    output = options.output.absolute()
    output.mkdir(parents=True, exist_ok=True)
    options.again = [file.absolute() for file in options.again or []]
    with copy_of_project() as root, open(output / "mutation.jsonl", "w", encoding="utf-8") as file:
        modules = [
            p.relative_to(root) for f in FOLDERS for p in sorted((root / "exudyn_inext" / f).glob("*.py"))
        ]
        modules = [m for m in modules if m.stem != "__init__" and m.stem in (options.modules or [m.stem])]
        for tests in sorted({tuple(tests_of(module.name)) for module in modules}):
            if not passes(list(tests), 10.0 * options.limit, output / "mutation_log.txt"):
                sys.exit(f"The tests fail without any change, see {output / 'mutation_log.txt'}.")
        results = []
        drawn = drawn_mutants(modules, options.share, options.seed)
        if options.again:
            settled = settled_before(options.again)
            results = [settled[_key(m)] for m in drawn if _key(m) in settled]
            drawn = [m for m in drawn if _key(m) not in settled]
            file.writelines(json.dumps(result) + "\n" for result in results)
        for mutant in tqdm(drawn, unit="mutant", mininterval=5.0):
            results.append(try_mutant(mutant, options.limit))
            print(json.dumps(results[-1]), file=file, flush=True)
    print(table(results))


if __name__ == "__main__":
    main()
