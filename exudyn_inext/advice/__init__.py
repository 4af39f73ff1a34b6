"""Which model, mesh, integrator and step a scene needs for a wanted accuracy: found by cheap pilot runs."""
