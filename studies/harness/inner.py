"""All that studies take from inside of the package: names that are not public, and may move."""
# ruff: noqa: F401

from exudyn_inext.adviser.pilot import CONVENTIONAL, INEXTENSIBLE, Choice, Pilot
from exudyn_inext.chain import factorisation, records
from exudyn_inext.chain.assembly import assemble, leave_targets
from exudyn_inext.chain.attached import PointMass
from exudyn_inext.chain.border import all_links, motions_of
from exudyn_inext.chain.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.chain.factorisation import factorise
from exudyn_inext.chain.frequency import FrequencyTracker, largest_frequency
from exudyn_inext.chain.implicit_bending import ImplicitBending
from exudyn_inext.chain.linked_cable import cable_system
from exudyn_inext.chain.records import element_type, node_type
from exudyn_inext.chain.saddle_point import solve_both_columns
from exudyn_inext.chain.sparse_forms import form_of_cable
from exudyn_inext.compiled import kernel, plain
from exudyn_inext.constraints import constraints_of_cable
from exudyn_inext.element.bending import stiffness_matrix
from exudyn_inext.element.inertia import mass_matrix
from exudyn_inext.exudyn_binding.advising.pilot_runs import PilotRuns
from exudyn_inext.exudyn_binding.cable_loads import CableLoads
from exudyn_inext.exudyn_binding.consistent_start import settle
from exudyn_inext.exudyn_binding.explicit_runs import cable_runs, scheme_of, step_bounds, wanted_step
from exudyn_inext.exudyn_binding.general.coupled_watch import STEPS_BETWEEN
from exudyn_inext.exudyn_binding.general.surroundings import switched_off
from exudyn_inext.exudyn_binding.scene import read_cables, read_scene
from exudyn_inext.exudyn_binding.scene_runs import runs_of_scene
from exudyn_inext.exudyn_binding.time_grid import TimeGrid
from exudyn_inext.integrators import find_integrator
from exudyn_inext.integrators.integrator import Integrator, LoadHistory, advance, no_loads, record
from exudyn_inext.integrators.linear_stability import GROWTH_TOLERANCE, decay_limit, frequency_limit
from exudyn_inext.integrators.step_size import choose_step, rule_step
from exudyn_inext.integrators.watch import record_watched
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.lowered import local_array
from exudyn_inext.statics import Potential, StaticOptions, find_equilibrium
from exudyn_inext.system import index_reduced_rates
