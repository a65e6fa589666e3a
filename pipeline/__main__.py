"""``python -m pipeline`` is ``rig2sea``."""

from pipeline.cli import main

main()
