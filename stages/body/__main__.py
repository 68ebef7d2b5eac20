"""Runs the stage as a program, see `stages.worker`; `preview` and `statistics` are for people."""

import importlib
import sys

from stages.worker import main

COMMANDS = {"preview": "stages.preview", "statistics": "stages.body.statistics"}

if len(sys.argv) > 1 and sys.argv[1] in COMMANDS:
    # By name, as the worker does with stages: the preview draws by means of another stage.
    sys.exit(importlib.import_module(COMMANDS[sys.argv[1]]).main(sys.argv[2:]))
main("body")
