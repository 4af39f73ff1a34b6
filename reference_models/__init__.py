"""The benchmark scenes, their reference trajectories, and the models that compute them.

scenes        what is to be computed: data only, SI units
data          independent reference trajectories with provenance
model, loads  what models share: sensors, settings, point forces
conventional  a scene as native Exudyn ANCF cables, with native integrators
inextensible  a scene as inextensible cables, with explicit integrators
"""
