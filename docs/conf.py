"""python -m sphinx -W --keep-going -b html docs build/docs

Neither the build nor the pages need a network.
"""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "extensions")]
os.environ["NUMBA_DISABLE_JIT"] = "1"  # kernels are plain functions, with docstrings

project = "exudyn_inext"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "docstrings",
    "import_diagram",
    "sphinx_copybutton",
    "equations",
    "offline",
    "source_pages",
]
myst_enable_extensions = ["dollarmath"]
exclude_patterns = ["extensions", "static"]
html_math_renderer = "equations"
html_static_path = ["static"]
html_css_files = ["pages.css"]
copybutton_selector = (
    "div.highlight-python pre, div.highlight-default pre, div.highlight-none pre"
)
html_theme = "furo"
html_title = "exudyn_inext"
html_copy_source = False
html_domain_indices = False
html_show_copyright = False

default_role = "code"
smartquotes = False
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # shapes and units are in the text
autodoc_preserve_defaults = True
