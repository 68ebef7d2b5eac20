"""Runs the stage as a program, see `stages.worker`; or solves a scene file, see `stages.simulate.scene_program`; or
measures the named fabrics, see `stages.simulate.fabrics_program`.
"""

import sys

if sys.argv[1:2] == ["scene"]:
    from stages.simulate.scene_program import main as solve_scene

    sys.exit(solve_scene(sys.argv[2:]))

if sys.argv[1:2] == ["fabrics"]:
    from stages.simulate.fabrics_program import main as measure_fabrics

    sys.exit(measure_fabrics(sys.argv[2:]))

from stages.worker import main

main("simulate")
