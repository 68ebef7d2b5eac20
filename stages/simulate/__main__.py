"""Runs the stage as a program, see `stages.worker`; or solves a scene file, see `stages.simulate.scene_program`."""

import sys

if sys.argv[1:2] == ["scene"]:
    from stages.simulate.scene_program import main as solve_scene

    sys.exit(solve_scene(sys.argv[2:]))

from stages.worker import main

main("simulate")
