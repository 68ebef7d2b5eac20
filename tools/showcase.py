"""Draws the README's picture: the people of a run in one row, with what they wear.

python tools/showcase.py build/demo docs/demo.png
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from stages.report.camera import Camera
from stages.report.gather import Person, read_person
from stages.report.render import Mesh, Studio
from stages.report.scene import heading
from stages.spec import Task

SPACING = 0.98  # [m]
# Where in its sequence each figure is taken, and how far it is turned from the camera [degrees].
MOMENTS, TURNS = (0.25, 0.8), (-35.0, 25.0)
FRONT = -0.5 * np.pi


def figures(people: Iterable[Person]) -> list[Mesh]:
    """Meshes of all people at all moments, in a row along x, each standing where its motion has it above the floor."""
    meshes: list[Mesh] = []
    row = [(person, moment, turn) for person in people for moment, turn in zip(MOMENTS, TURNS)]
    for place, (person, moment, turn) in enumerate(row):
        frame = round(moment * (len(person.pose) - 1))
        about_z = Rotation.from_euler("z", FRONT + np.radians(turn) - heading(person.pose[frame : frame + 1, 0]))
        shift = np.array([(place - 0.5 * (len(row) - 1)) * SPACING, 0.0, person.trans[frame, 2]])
        for surface in person.surfaces():
            mesh = surface.at(frame)
            local = np.asarray(mesh.vertices) - person.trans[frame]
            meshes.append(replace(mesh, vertices=about_z.apply(local) + shift))
    return meshes


def main() -> None:
    """Reads the run's shards and writes the picture."""
    parser = argparse.ArgumentParser(description="Draw the people of a run in one row.")
    parser.add_argument("output", type=Path, help="the run's output, such as build/demo")
    parser.add_argument("picture", type=Path, help="PNG to write")
    parser.add_argument(
        "--size", type=int, nargs=2, default=(1280, 460), metavar=("W", "H"), help="of the picture [px]"
    )
    given = parser.parse_args()
    task = Task.from_json((given.output / "tasks" / "report" / "all.json").read_text())
    meshes = figures(read_person(task, item) for item in sorted(task.inputs["simulate"]))
    width, height = given.size
    camera = Camera.around(np.array([0.0, 0.0, 0.93]), FRONT, height=2.3, elevation=0.07)
    picture = Image.fromarray(Studio(meshes).picture(camera, width, height))
    given.picture.parent.mkdir(parents=True, exist_ok=True)
    picture.save(given.picture, optimize=True)


if __name__ == "__main__":
    main()
