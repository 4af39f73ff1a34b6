"""Multibody scenes with inextensible cables, each a script of its own: python examples/crane.py

What scripts share lies beside them, where Python looks for it when it runs one; and so it does if another
module imports them.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
