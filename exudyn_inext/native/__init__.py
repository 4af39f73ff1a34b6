"""Scenes of cables among other items: bodies, connectors, joints, loads on anything."""
