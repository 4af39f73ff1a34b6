"""Which folders a wheel has; all else stands in pyproject.toml.

Studies, and the scenes that they need, go below the package: among installed packages, names such as
`studies` and `examples` would collide with those of other projects. `exudyn_inext/studies.py` finds them.
"""

from setuptools import find_packages, setup

PACKAGE, BUNDLE = "exudyn_inext", "exudyn_inext.bundle"
BUNDLED = ("studies", "examples", "reference_models")

bundled = find_packages(include=[pattern for name in BUNDLED for pattern in (name, f"{name}.*")])
setup(
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]) + [f"{BUNDLE}.{name}" for name in bundled],
    package_dir={f"{BUNDLE}.{name}": name for name in BUNDLED},
    package_data={"": ["py.typed", "*.csv", "*.json", "PROVENANCE.md", "*.css"]},
)
