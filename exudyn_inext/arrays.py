"""The array type of all public formulas."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
