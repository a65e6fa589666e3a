"""``python -m pipeline`` is ``rig2sea``."""

import sys
from pathlib import Path

# Python looks for modules in the working folder first when it is started so: a file numpy.py or
# queue.py that lies there, as rig data may, is not to be run.
if not sys.flags.safe_path and sys.path and Path(sys.path[0]).resolve() == Path.cwd():
    del sys.path[0]

from pipeline.cli import main

main()
