"""Runs the stage as a program; see `stages.worker`."""

from stages.worker import main

main("register")
