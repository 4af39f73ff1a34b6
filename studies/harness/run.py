"""One study from start to files: measure, compare, store, draw, report."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from exudyn_inext.errors import InputError
from reference_models.scenes import Scene
from reference_models.trajectory import Case

from .benchmark import Benchmark, run_benchmark
from .document import Document, concluded, measured, store
from .error import interpolation_error
from .progress import announce
from .ratios import ratio_sentences, ratio_tables
from .reference import ReferenceSolution
from .rows import make_row
from .store import prepare_directory
from .study import Results, Study
from .sweep.study import SweepOptions, SweepStudy, run_sweep_study
from .table import number, rows_table
from .timing import Measurement, measure

QUICK_REPEATS = 2


def run(
    study: Study | Benchmark | SweepStudy,
    output: Path,
    quick: bool = False,
    options: SweepOptions | None = None,
) -> str:
    """Run a study of any kind, write NAME.json, NAME.md and pictures; return the report.

    options: of a study that sweeps; others take none.
    """
    if isinstance(study, SweepStudy):
        return run_sweep_study(study, output, quick, options)
    if options not in (None, SweepOptions()):
        raise InputError(
            f"study '{study.name}' times its cases in one process and sweeps over nothing: leave out "
            "--workers, --dask, --mpi, --fresh and --retry-failed."
        )
    if isinstance(study, Benchmark):
        return run_benchmark(study, output, quick)
    return run_study(study, output, quick)


def run_study(study: Study, output: Path, quick: bool = False) -> str:
    """Run the comparison, write NAME.json, NAME.md and pictures into `output`; return the report."""
    prepare_directory(output)
    scene = study.scene
    if quick:
        scene = replace(scene, end_time=min(scene.end_time, study.quick_end_time))
    announce(study.name, "preparing the reference and the cases, finding stable steps")
    reference = study.reference(scene)
    cases = study.cases(scene, quick)
    _require_distinct_labels(cases)
    results = _results(scene, quick, _measure(study, cases, quick), reference)
    document = _document(study, results)
    store(output, document)
    announce(study.name, "drawing the figures")
    figures = study.figures(results, output)
    return store(output, _concluded(study, results, document), figures)


def _measure(study: Study, cases: Sequence[Case], quick: bool) -> list[Measurement]:
    repeats = QUICK_REPEATS if quick else study.repeats
    with tqdm(total=len(cases) * (repeats + 1), desc=study.name, unit="run") as progress:

        def advance(label: str) -> None:
            progress.set_postfix_str(label[:48])
            progress.update()

        return measure(cases, repeats, advance)


def _require_distinct_labels(cases: Sequence[Case]) -> None:
    labels = [case.label for case in cases]
    repeated = {label for label in labels if labels.count(label) > 1}
    if repeated:
        raise ValueError(f"labels {sorted(repeated)} occur more than once; make them distinct.")


def _results(
    scene: Scene, quick: bool, measurements: Sequence[Measurement], reference: ReferenceSolution
) -> Results:
    return Results(
        scene=scene,
        quick=quick,
        rows=[make_row(measurement, reference.trajectory) for measurement in measurements],
        trajectories={
            measurement.case.label: measurement.trajectory
            for measurement in measurements
            if measurement.trajectory is not None
        },
        reference=reference,
    )


def _document(study: Study, results: Results) -> Document:
    """What is known before conclusions are drawn and pictures made."""
    reference = results.reference
    interpolation = interpolation_error(reference.trajectory)
    mode = f"quick: {results.scene.end_time:g} s of motion" if results.quick else ""
    return measured(study.name, study.question, results.quick, results.rows, mode) | {
        "paper": study.paper,
        "reference": {
            "file": reference.file,
            "source": reference.source,
            "uncertainty": reference.uncertainty,
            "interpolationErrorMax": interpolation.maximum,
            "interpolationErrorRms": interpolation.rms,
        },
    }


def _concluded(study: Study, results: Results, document: Document) -> Document:
    ratios = study.ratios(results)
    tables = [rows_table(results.rows), *study.tables(results), *ratio_tables(ratios)]
    conclusions = study.conclusions(results) + ratio_sentences(ratios, results.quick)
    note = _note(document["reference"])
    return concluded(document, tables, conclusions, [note], [vars(ratio) for ratio in ratios])


def _note(reference: dict[str, Any]) -> str:
    """What the errors are."""
    return (
        f"Errors are distances to: {reference['source']}, good to "
        f"{reference['uncertainty']:.0e} m; between its samples a spline, whose error at twice "
        "the sampling period is "
        f"{number(reference['interpolationErrorMax'], 2)} m at most, "
        f"{number(reference['interpolationErrorRms'], 2)} m rms."
    )
