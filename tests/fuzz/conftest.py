"""Where the modules lie that build logs and workbooks for the tests."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "unit" / "ingest"))
