"""All that studies take from inside of the package: names that are not public, and may move."""
# ruff: noqa: F401

from exudyn_inext.advice.pilot import CONVENTIONAL, INEXTENSIBLE, Choice, Pilot
from exudyn_inext.cable.cable import Cable
from exudyn_inext.cable.frequency import FrequencyTracker, largest_frequency
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.cable.records import element_type, node_type
from exudyn_inext.exudyn_binding.advising.pilot_runs import PilotRuns
from exudyn_inext.exudyn_binding.scene import initial_states, read_scene
from exudyn_inext.exudyn_binding.scene_runs import runs_of_cables as cable_runs
from exudyn_inext.exudyn_binding.scene_runs import runs_of_scene
from exudyn_inext.integrators.integrator import LoadHistory, record
from exudyn_inext.integrators.linear_stability import GROWTH_TOLERANCE, decay_limit, frequency_limit
from exudyn_inext.native.native_items import switched_off
from exudyn_inext.run.cable_loads import CableLoads
from exudyn_inext.run.consistent_start import settle
from exudyn_inext.run.coupled_watch import STEPS_BETWEEN
from exudyn_inext.run.step_choice import largest_step, rule_of_cable, rule_step, step_bounds
from exudyn_inext.run.step_control import Piece
from exudyn_inext.run.time_grid import TimeGrid
from exudyn_inext.run.watch import record_watched
from exudyn_inext.statics import potential_of
from exudyn_inext.system import index_reduced_rates
