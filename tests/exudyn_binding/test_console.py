"""What Exudyn prints of explicit runs speaks of explicit steps, with right rates; of statics, of success."""

import re
import time

import exudyn
import pytest

from exudyn_inext import (
    CreateInextensibleCable,
    ExplicitSolver,
    InextensibleCable,
    SolveEquilibrium,
    SolveExplicit,
)
from reference_models.model import quiet_settings

WAIT, STEPS = 0.03, 20  # [s]


@pytest.fixture
def printed(capfd):
    """What is printed on a run with that verboseMode, whose pre-step function waits; its cable hangs."""

    def run(verbose, wait=0.0, explicit=SolveExplicit):
        mbs = exudyn.SystemContainer().AddSystem()
        section = InextensibleCable(massPerLength=0.1, bendingStiffness=1e-2)
        pin = {"gravity": [0, -9.81, 0], "groundConstraintsStart": [True, True, False, False]}
        CreateInextensibleCable(mbs, [0, 0, 0], [0, -1, 0], 4, section, **pin)
        mbs.SetPreStepUserFunction(lambda mbs, t: time.sleep(wait) is None)
        mbs.Assemble()
        settings = quiet_settings(0.1, STEPS)
        settings.timeIntegration.verboseMode = verbose
        explicit(mbs, settings)
        assert settings.timeIntegration.verboseMode == verbose
        return capfd.readouterr().out

    return run


def test_a_quiet_run_prints_nothing(printed):
    assert printed(0) == ""


def test_a_run_speaks_of_explicit_steps(printed):
    said = printed(1)
    assert re.search(r"EXUDYN V\S+ solver: explicit time integration \(RATTLE", said)
    assert re.search(r"h = 0\.\d+s \(decided by .*explicit steps in each STEP = \d", said)
    assert f"STEP{STEPS}, t = 0.1s, timeToGo = 0s" in said and "terminated successfully" in said
    assert "implicit" not in said and "Nit/step" not in said


def test_an_equilibrium_that_is_written_is_a_success(printed):
    said = printed(1, explicit=SolveEquilibrium)
    assert "static solver" in said and "terminated successfully" in said


def test_a_driven_solver_speaks_of_explicit_steps(printed):
    def drive(mbs, settings):
        solver = ExplicitSolver()
        solver.InitializeSolver(mbs, settings)
        solver.SolveSteps(mbs, settings)
        solver.FinalizeSolver(mbs, settings)

    said = printed(1, explicit=drive)
    assert "explicit time integration (RATTLE" in said and "h = 0.0" in said
    assert "implicit" not in said and "Nit/step" not in said


def test_the_time_to_go_is_that_of_the_steps_that_are_left(printed):
    to_go = dict(re.findall(r"STEP(\d+), t = \S+ timeToGo = (\S+)s", printed(2, WAIT)))
    left = 5 * WAIT
    assert left < float(to_go[str(STEPS - 5)]) < 4.0 * left


@pytest.mark.parametrize("limit, loop_steps", [(1.0, STEPS), (1e-9, 0)])
def test_a_run_ends_at_the_timeout_of_exudyn_and_not_before(limit, loop_steps, printed, monkeypatch):
    """Exudyn's clock goes since its import, longer than the first limit [s]; the run takes some 10 ms."""
    printed(0)  # compiles
    monkeypatch.setattr(exudyn.special.solver, "timeout", limit)
    reports = []
    printed(0, explicit=lambda mbs, settings: reports.append((SolveExplicit(mbs, settings), mbs)))
    ((report, mbs),) = reports
    assert mbs.systemData.GetTime() == pytest.approx(0.1 * loop_steps / STEPS)
    assert (report["steps"] > 0) == (report["meanStepSize"] > 0.0) == (loop_steps > 0)
