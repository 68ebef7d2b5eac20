"""`python -m stages.train --task TASK.json`."""

from stages.worker import main

main("train")
