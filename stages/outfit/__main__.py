"""Runs the stage as a program, see `stages.worker`; `body` and `check` are for people with garments of their own."""

import sys

from stages.worker import main

if len(sys.argv) > 1 and sys.argv[1] in ("body", "check"):
    from stages.outfit.own.program import main as own

    sys.exit(own(sys.argv[1:]))
main("outfit")
