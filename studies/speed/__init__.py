"""The table of benchmarks: what each varies, what it times, and which bars it has to keep.

The question and the protocol of a benchmark head the module of its name, which holds what is timed.
To add one, add an entry.
"""

import math

from studies.harness.bars import Bar
from studies.harness.benchmark import Series, benchmark, varied

from . import ensemble, kernel, pictures, realtime, scaling, scene_cost, soak, watch_cost

INTEGRATORS = ("Zhai", "RATTLE")
LONG = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
_WATCH = (
    "cable: label | N: elements | step [us]: microseconds | watch/step: share | not below: low | "
    "not above: high"
)

STUDIES = (
    benchmark(
        "kernel", "What does one inextensible step cost against one native evaluation of as many elements?",
        [Series(
            "ratio",
            varied({"elements": (5, 20), "curvatureMeasure": kernel.MEASURES[:1]}, dimension=(2, 3),
                   elements=(5, 20, 50), curvatureMeasure=kernel.MEASURES, integrator=INTEGRATORS),
            kernel.row, kernel.tasks, ("dimension", "elements"), rounds=(3, 15), least=(4e-3, 2e-2),
        )],
        [
            Bar("ratio", "ratio", "{}D: a step over a native ComputeODE2RHS of as many elements", "bar",
                "dimension"),
            Bar("ratio", "ratioLobatto", "{}D: the same with the Lobatto quadrature", per="dimension"),
        ],
        """
        ratio: Microseconds, and ratios to one native ComputeODE2RHS:
            what: label | N: elements | curvature: curvatureMeasure | time [us]: microseconds |
            native [us]: nativeMicroseconds | ratio | ratio, Lobatto: ratioLobatto | bar
        """,
        minutes=1,
    ),
    benchmark(
        "scaling", "Does an element cost the same in short and in very long cables?",
        [
            Series(
                "cost",
                varied({"elements": (20, 200)}, chain=tuple(scaling.CHAINS), integrator=INTEGRATORS,
                       elements=LONG),
                scaling.cost, scaling.steps, ("chain", "integrator"), rounds=(3, 9), least=(5e-3, 5e-2),
            ),
            Series(
                "memory",
                varied({"elements": (3000,), "steps": (5,)}, chain=("2D", "3D"), elements=(100_000,),
                       steps=(20,)),
                scaling.memory,
            ),
            Series(
                "accuracy",
                varied({"elements": (10, 100), "motion": (0.5,)}, motion=(5.0,), integrator=INTEGRATORS,
                       elements=(10, 100, 1000, 5000)),
                scaling.accuracy, scaling.motion, rounds=(2, 5),
            ),
        ],
        [
            Bar("cost", "microseconds", "{}: CPU time per element and step over the least", 1.25, "label",
                over_least=True),
            Bar("memory", "peakMegabytes", "memory of long cables [MB]", 1000.0, noise=1.0),
            Bar("accuracy", "errorMax", "error with scaled mass [m]", 1e-3, noise=1.0),
            Bar("accuracy", "realTime", "seconds of motion a second of CPU time", 1.0, is_least=True),
        ],
        """
        cost: CPU time per element and step, and the memory that a step goes through:
            chain: label | N: elements | us/(N step): microseconds | memory of a step [MB]: megabytes
        memory: Resident memory of a long cable:
            chain: label | N: elements | libraries [MB]: librariesMegabytes |
            with model [MB]: modelMegabytes | peak [MB]: peakMegabytes | start [s]: startSeconds |
            us/(N step): microseconds
        accuracy: Planar pendulum with mass scaling 0.3 at h = 2e-3 s:
            run: label | N: elements | motion [s]: motion | CPU [s]: cpuSeconds | us/(N step): microseconds |
            times real time: realTime | error max [m]: errorMax | error rms [m]: errorRms
        """,
        pictures=pictures.cost_of_elements, minutes=2,
    ),
    benchmark(
        "realtime", "How long does a single step take at worst, against the step size?",
        [Series("step", realtime.cases, realtime.row, realtime.portions, rounds=(2, 100))],
        [
            Bar(realtime.steps, "percentile999", "wall time of 99.9 % of the steps [us]", 1000.0, noise=5.0),
            Bar(realtime.steps, "cpuWorst", "CPU time of the longest step [us]"),
            Bar("step", "worst", "{}: wall time of the longest one [us]", per="what"),
        ],
        """
        step: Time of single calls, wall time unless stated:
            what: label | calls: samples | median [us]: median | 99.9 % [us]: percentile999 |
            worst [us]: worst | CPU 99.9 % [us]: cpuPercentile999 | CPU worst [us]: cpuWorst |
            h / 99.9 %: stepOverPercentile999 | share above h: lateShare
        """,
        pictures=pictures.late_steps, minutes=0.3,
    ),
    benchmark(
        "scene_cost", "What does a step cost, by what the scene contains, and which path does it take?",
        [Series("cost", scene_cost.cases, scene_cost.row, scene_cost.runs, rounds=(1, 7))],
        [Bar(scene_cost.growth, "more", "{}: us for one more; the bar is 1.5 times that among few", "bar",
             "label")],
        """
        cost: CPU time of a step and of the start:
            series: label | cables | elements | springs | points | bodies | joints |
            us a step: microseconds | start [ms]: startMilliseconds | path
        """,
        pictures=pictures.cost_of_scenes, minutes=1,
    ),
    benchmark(
        "watch_cost", "What does it cost that each run is watched?",
        [
            Series(
                kind,
                varied({"dimension": (2,), "scene": few, "elements": (5,)}, dimension=dimensions,
                       scene=scenes, elements=(5, 20), integrator=INTEGRATORS),
                watch_cost.row, tasks, ("dimension", "scene", "elements"), rounds, (0.01, 0.01),
            )
            for kind, tasks, dimensions, scenes, few, rounds in (
                ("alone", watch_cost.alone, (2, 3), watch_cost.ALONE, watch_cost.ALONE[:1], (5, 21)),
                ("among bodies", watch_cost.among_bodies, (2,), *[watch_cost.AMONG_BODIES] * 2, (3, 41)),
            )
        ],
        [
            Bar(kind, "share", f"cables {kind}, the watch over a step", "bar", noise=math.inf)
            for kind in ("alone", "among bodies")
        ],
        f"""
        alone: Cables alone, inspections over the steps without them:
            {_WATCH}
        among bodies: Among bodies:
            {_WATCH}
        """,
        minutes=4,
    ),
    benchmark(
        "soak", "Do energy, constraints and memory stay where they are over long runs and many scenes?",
        [
            Series("run", soak.runs, soak.watched_run),
            Series("memory", soak.ways, soak.dropped),
        ],
        [
            Bar("run", soak.drift_of, "{}: drift of the mean energy over its range", soak.DRIFT, "label",
                noise=math.inf),
            Bar("run", "violation", "violation of a constraint", soak.VIOLATION, noise=1.0),
            Bar("memory", "growthPercent", "{}: growth of the memory [%]", 100.0 * soak.GROWTH, "label",
                noise=math.inf),
        ],
        """
        run: Planar pendulum, RATTLE; energies over the swing, the largest kinetic energy:
            run: label | steps | motion [h]: hours | CPU [s]: cpuSeconds | energy varies by: range |
            its mean drifts by: drift | violation | of rates [1/s]: rate
        memory: Resident memory of a process that builds, runs and drops scenes:
            way of the run: label | scenes | first [MB]: firstMegabytes | last [MB]: lastMegabytes |
            kB a scene: kilobytesAScene | growth [%]: growthPercent
        """,
        pictures=pictures.energy_and_memory, minutes=4,
        not_in_quick_report="short runs and few scenes decide nothing on drift and memory",
    ),
    benchmark(
        "ensemble", "What does a pendulum cost among a thousand others, and how much do more cores do?",
        [Series(
            "ensemble", ensemble.cases, ensemble.row, ensemble.tasks, ("elements", "endTime", "label"),
            rounds=(2, 5), rotates=False,
        )],
        [
            Bar("ensemble", "costRatio", "a cable in the ensemble over a cable alone", 1.0),
            Bar("ensemble", "gain", "motions of {} s: speed of all free cores over one",
                ensemble.GAIN, "endTime", is_least=True),
            Bar("ensemble", "isEqual", "motions alone, in the ensemble, on all cores are equal (1)", 1.0,
                is_least=True, noise=1.0),
        ],
        """
        ensemble: Milliseconds a cable (CPU time; for all cores, wall time):
            parameters: label | members | N: elements | motion [s]: endTime | h [s]: stepSize |
            alone [ms]: alone | one core [ms]: together | ratio: costRatio |
            all cores [ms]: wallOfAllCores | gain | quiet rounds: quietRounds
        """,
        minutes=5,
    ),
)  # fmt: skip
