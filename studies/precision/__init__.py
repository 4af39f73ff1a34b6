"""Parts of `work_precision`.

families         which rows form a front together
reading          fronts, what an accuracy costs by interpolation, ratios
inextensible     cases of the package        native   cases of conventional cables
enforced         inextensible cables under native solvers
links            cases of rigid links
scene_run        measuring one scene
findings         sentences                   pictures
"""
