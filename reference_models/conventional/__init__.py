"""A scene as native Exudyn ANCF cables (the paper's conventional formulation).

model       builds the mbs            supports   pins and clamps
settings    what the solver is told   solve      one run of a built model
stability   largest stable steps      cases      rows of a comparison
"""
