"""A scene as native Exudyn ANCF cables (the paper's conventional formulation).

model       builds the mbs                     cable      elements, gravity, initial velocities
supports    pins, clamps and hangers           settings   what the solver is told
solve       one run of a built model           equilibrium static start of a motion
stability   largest stable steps               cases      rows of a comparison
zhai        the paper's explicit method on native cables
"""
