"""A scene as others would model it, for comparison: optional, each with a package of its own (extra `peers`).

rigid_links   a truly inextensible chain of rigid links in MuJoCo
"""
