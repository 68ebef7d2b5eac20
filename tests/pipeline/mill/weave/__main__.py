"""Runs the stage as a program."""

from stages.worker import main

main("weave", package="mill")
