"""Small scenes that the tests of the simulation share; `small_scenes` is importable beside them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
