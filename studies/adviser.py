"""The adviser on scenes that it was not tuned on: does it keep what it promises?

Question
    Is the error of what `Advise` recommends as it predicted, and within the tolerance?

What would refute it
    Errors further than a factor 3 from the prediction, or outside of the tolerance in more than 10 % of
    the cases.

Protocol
    The adviser was written and tuned on the paper's four scenes. Here it meets others: wires, ropes and
    rubber, thrown, kicked, clamped, closed, in space. Tolerances 1e-2, 3e-3, 1e-3 and 3e-4 of the length.
    "Few meshes": pilots have 4, 6, 8 elements at most, so that it must extrapolate. What it recommends is run
    again, and compared with a finer solution of another integrator: Zhai (RK4 where it diverges), 48
    elements, half of its limit, and one with 32 for its uncertainty; for rubber, where stretch matters,
    native cables, 24 and 16 elements. Cases whose tolerance is below four times that uncertainty say
    nothing and are left out.
    Predicted CPU time is that of the pilot, or the cost model's; achieved is that of the run again.

What is left out
    Bodies and contact; budgets.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product

from tqdm import tqdm

from exudyn_inext import AdviceSettings, DivergenceError, InextensibleError
from reference_models.advice import advise_scene, builder
from reference_models.conventional.model import build as build_native
from reference_models.inextensible import build
from reference_models.model import SENSOR_PERIOD
from reference_models.scenes import Scene, load_scene
from reference_models.scenes.load import PointForce, Sine
from reference_models.scenes.scene import Cable
from reference_models.scenes.section import Round, Section
from reference_models.scenes.shape import Circle, Line, Parabolas
from reference_models.scenes.support import Clamp, Pin

from .harness import Results, Row, Study, Table, inner
from .harness.bars import Bar, conclusions

TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4)  # of the length
FEW = AdviceSettings(numbersOfElements=(4, 6, 8))
FACTOR, SHARE = 3.0, 0.9
LEAST_OVER_UNCERTAINTY = 4.0
FINE, COARSER = 48, 32
INTEGRATORS = ("Zhai", "RK4")
CHOICE = ("formulation", "integrator", "numberOfElements", "stepSize", "massScaling")
ADVISED = (
    "formulation", "extrapolated", "predictedError", "predictedSeconds", "pilotSeconds", "meetsTolerance",
    "reasons",
)  # fmt: skip
FINE_NATIVE, COARSER_NATIVE = (24, 1.0 / 32.0), (16, 1.0 / 16.0)  # elements, step over sample period


_G = (0.0, -9.81, 0.0)
_WIRE = Round(radius=1e-3, density=7850.0, youngs_modulus=2.0e11)
_ROPE = Section(mass_per_length=0.15, bending_stiffness=0.02, axial_stiffness=4e5)
_RUBBER = Section(mass_per_length=0.08, bending_stiffness=0.02, axial_stiffness=50.0)


def _hanging(name: str, section: Section, length: float, end_time: float) -> Scene:
    """Pinned, released when horizontal."""
    return Scene(
        name=name,
        cable=Cable(length, section),
        supports=(Pin(at=0.0),),
        gravity=_G,
        end_time=end_time,
        observe={"tip": 1.0},
    )


def _ring() -> Scene:
    circle, drive = Circle(radius=0.3), Sine(angular_frequency=6.0 * math.pi)
    ends = ((0.0, 3.0), (0.5, -3.0))
    return replace(
        load_scene("vibrating_ring"),
        name="small ring, pulled",
        cable=Cable(circle.circumference, _WIRE, circle),
        end_time=1.0,
        reference=None,
        loads=tuple(PointForce(at=s, force=(x, 0.0, 0.0), history=drive) for s, x in ends),
    )


def _sagging() -> Scene:
    return replace(
        _hanging("rope that drops a weight", _ROPE, 2.12, 2.0),
        cable=Cable(2.12, _ROPE, Parabolas(width=2.0, sag=0.3), "straight"),
        supports=(Pin(at=0.0), Pin(at=1.0)),
        observe={"middle": 0.5},
        start_loads=(PointForce(at=0.5, force=(0.0, -3.0, 0.0)),),
        starts_from_equilibrium=True,
    )


def validation_scenes() -> list[Scene]:
    """One of each kind; the last one is made of rubber."""
    wire = _hanging("steel wire", _WIRE, 1.0, 1.5)
    hanging = Cable(0.8, _WIRE, Line(direction=(0.0, -1.0, 0.0)))
    return [
        wire,
        _hanging("soft rope", _ROPE, 0.6, 1.2),
        replace(_hanging("moon", _WIRE, 2.0, 5.0), gravity=(0.0, -1.62, 0.0)),
        replace(wire, name="kicked wire", cable=hanging, end_velocity=(3.0, 0.0, 0.0), end_time=1.5),
        replace(wire, name="wire kicked in space", cable=hanging, end_velocity=(2.0, 0.0, 2.5)),
        replace(wire, name="falling cantilever", cable=Cable(0.5, _WIRE), supports=(Clamp(at=0.0),)),
        replace(wire, name="thrown wire", supports=(), end_velocity=(0.0, 4.0, 0.0), end_time=1.0),
        _ring(),
        _sagging(),
        replace(load_scene("planar_pendulum"), name="two seconds of Table 1", end_time=2.0),
        _hanging("rubber band", _RUBBER, 1.0, 1.0),
    ]


def measure(quick: bool) -> list[Row]:
    """One row a piece of advice."""
    scenes = validation_scenes()[1:3] if quick else validation_scenes()
    tolerances = TOLERANCES[: 2 if quick else None]
    return [
        row for scene in tqdm(scenes, desc="adviser", unit="scene") for row in _rows_of(scene, tolerances)
    ]


def _rows_of(scene: Scene, tolerances: Sequence[float]) -> Iterator[Row]:
    native = builder(scene, partial(build_native, quadrature="lobatto"))
    runs = inner.PilotRuns(builder(scene, build), native, scene.end_time, SENSOR_PERIOD)
    stretching = runs.stretching(scene.cable.section.axial_stiffness)
    reference_of = lru_cache(partial(_reference, runs))
    asked = (("measured", AdviceSettings()), ("few meshes", FEW))
    for share, (what, settings) in product(tolerances, asked):
        tolerance = share * scene.cable.length
        row = {"kind": "advice", "label": scene.name, "what": what, "value": tolerance, "status": "ok"}
        try:
            advice = advise_scene(scene, tolerance, settings=settings)
        except InextensibleError as error:
            yield row | {"status": f"refused: {error}"}
        else:
            followed = stretching if advice["formulation"] == "extensible" else runs
            yield row | _outcome(advice, tolerance, followed, *reference_of(advice["formulation"]))


def _outcome(
    advice: Row, tolerance: float, runs: inner.PilotRuns, reference: inner.Pilot, uncertainty: float
) -> Row:
    choice = inner.Choice(*(advice[key] for key in CHOICE))
    again = runs.run(choice)
    row = {
        "choice": choice.label,
        **{key: advice[key] for key in ADVISED},
        "achievedSeconds": again.seconds,
        "referenceUncertainty": uncertainty,
    }
    if again.failure:
        return row | {"status": f"failed: {again.failure}"}
    if tolerance < LEAST_OVER_UNCERTAINTY * uncertainty:
        return row | {"status": "not judged: the reference is too uncertain"}
    error = again.distance(reference)
    return row | {"achievedError": error, "ratio": error / advice["predictedError"]}


def _reference(runs: inner.PilotRuns, formulation: str) -> tuple[inner.Pilot, float]:
    """A fine solution that the adviser has not seen, and its uncertainty."""
    if formulation != inner.INEXTENSIBLE:
        choices = [
            inner.Choice(inner.CONVENTIONAL, "generalizedAlpha", elements, share * SENSOR_PERIOD)
            for elements, share in (FINE_NATIVE, COARSER_NATIVE)
        ]
        fine, coarser = (runs.run(choice) for choice in choices)
    else:
        coarser, fine = (_fine_run(runs, elements) for elements in (COARSER, FINE))
    return fine, fine.distance(coarser)


def _fine_run(runs: inner.PilotRuns, elements: int) -> inner.Pilot:
    """By the first integrator that gets to the end."""
    for integrator in INTEGRATORS:
        limit = runs.step_limit(elements, integrator)
        pilot = runs.run(inner.Choice(inner.INEXTENSIBLE, integrator, elements, 0.5 * limit))
        if not pilot.failure:
            return pilot
    raise DivergenceError(pilot.failure)


def _off(row: Row) -> float | None:
    """Error over its prediction, or the prediction over it."""
    return max(row["ratio"], 1.0 / row["ratio"]) if "ratio" in row else None


def _over(row: Row) -> float | None:
    """Error over the tolerance, where it was said to be within."""
    return row["achievedError"] / row["value"] if row.get("meetsTolerance") and "ratio" in row else None


BARS = conclusions(
    Bar("advice", _off, "how far errors are from their predictions, as a factor", FACTOR, noise=1.0),
    Bar("advice", _over, "error over the tolerance that it was said to keep", 1.0, noise=1.0, share=SHARE),
)


def conclude(results: Results) -> list[str]:
    """How often the advice was right, and how often that could not be judged."""
    rows = results.of_kind("advice")
    judged, refused = sum("ratio" in row for row in rows), sum(row["status"][:7] == "refused" for row in rows)
    return [*BARS(results), f"{judged} of {len(rows)} cases could be judged; {refused} were refused."]


TABLE = Table(
    "advice",
    "Advice, and what came of it; errors in m:",
    "scene: label | mesh and error: what | tolerance: value | advice: choice | "
    "predicted error: predictedError | achieved: achievedError | achieved/predicted: ratio | "
    "reference good to: referenceUncertainty | predicted CPU [s]: predictedSeconds | "
    "achieved CPU [s]: achievedSeconds | pilots [s]: pilotSeconds | status",
)

QUESTION = "Does the adviser keep what it promises, on scenes that it was not tuned on?"
STUDY = Study("adviser", QUESTION, measure, conclude, [TABLE], minutes=2)
