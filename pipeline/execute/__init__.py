"""Ways to run a plan's tasks: on this machine, by worker processes."""
