"""What an integrator sees of a mechanical system: a small protocol, dispatched on its type.

A system is a NamedTuple; the module that defines it registers an implementation with `implements`.
The same call works in compiled code (resolved when compiling) and in plain Python.

Kernels that take any system see it as `Called`, see `called_system`: they are compiled once for all types.
"""

from .compiled import protocol


@protocol
def index_reduced_rates(system, external, q, v, acceleration, rate):
    """Right-hand side of the index-reduced equations, Eq. (30).

    Args:
        system: the mechanical system.
        external: (n_dof, ...) external generalised force at the time of (q, v); a system whose
            constraints move appends the motions.
        q: (n_dof,) coordinates.   v: (n_dof,) velocities.
        acceleration: (n_dof,) output dv/dt.
        rate: (n_dof,) output dq/dt: the velocity, projected and stabilised.
    """


@protocol
def accelerate_and_project(system, external, q, v, duration, acceleration, end_velocity):
    """Constrained acceleration at q, and the velocity after it has acted, on the constraint manifold.

    M a + C_q^T lam = F with C_q a = gamma; v_end = v + duration a + M^-1 C_q^T nu with C_q v_end = 0.

    Args:
        system: the mechanical system.
        external: (n_dof,) external generalised force.
        q: (n_dof,) coordinates.   v: (n_dof,) velocities.
        duration: for which the acceleration acts [s].
        acceleration: (n_dof,) output a; on entry the last one: forces that depend on the velocity are
            evaluated at v + duration times it.
        end_velocity: (n_dof,) output v_end; must not be the array v.
    """


@protocol
def accelerate(system, external, q, v, duration, stabilises, acceleration, rate):
    """Both of these, of systems that are called by address: they are compiled once for both.

    stabilises: 1 for `index_reduced_rates`, with a duration of 0; 0 for `accelerate_and_project`.
    """


@protocol
def correct_position(system, external, q, tolerance, learning, correction):
    """One step back to the constraint manifold along the last Jacobian: C_q d = -c(q).

    Args:
        system: the mechanical system, after `accelerate_and_project`.
        external: what moves the constraints, at the time of q.
        q: (n_dof,) coordinates off the manifold.
        tolerance: a smaller violation is not corrected [-].
        learning: 2/h^2 [1/s^2] if the violation is to correct the next steps' constraint accelerations,
            which are smooth in time; 0 otherwise.
        correction: (n_dof,) output d = -M^-1 C_q^T mu.

    Returns:
        Largest violation |c(q)| [-] before the correction; lengths relative to the element. Where it is
        below the tolerance, the correction is not set.
    """


# what `report_energy` gives
KINETIC, ELASTIC, POWER, VIOLATION, ACCELERATION_ENERGY, RESOLVED = 0, 1, 2, 3, 4, 5
REPORTED = 6


@protocol
def report_energy(system, external, q, v, a, force, energy_report):
    """Energies and violated constraints of a state, for whoever watches a run.

    Args:
        system: the mechanical system, evaluated at (q, v) last.
        external: external generalised force at the time of (q, v), with motions behind it.
        q: (n_dof,) coordinates.   v: (n_dof,) velocities.   a: (n_dof,) accelerations.
        force: (n_dof,) output: forces whose work is to be counted along the coordinates [N, Nm].
        energy_report: (6,) output: kinetic and elastic energy [J]; power [W] of what is in neither
            nor in `force` (damping, drag, moving constraints); largest violation of a constraint [-], lengths
            relative; a . M a / 2 [J/s^2]; the same without vibrations that are implicit and that the step
            does not resolve.
    """
