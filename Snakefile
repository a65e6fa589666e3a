"""The workflow lies in the package, so that an installed rig2sea has it too."""

import os

import pipeline


include: os.path.join(os.path.dirname(pipeline.__file__), "rules", "workflow.smk")


# the engine takes the default from this file alone
workflow.default_target = "all"
