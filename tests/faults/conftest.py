"""Where the module lies that makes a synthetic bench."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "integration"))
