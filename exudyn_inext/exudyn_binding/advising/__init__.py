"""Advice on formulation, mesh, integrator and step, from pilot runs inside Exudyn."""
