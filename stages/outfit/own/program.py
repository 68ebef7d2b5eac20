"""`python -m stages.outfit body|check`: the body to place a garment on, and whether a garment can be worn."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from model.mesh.geometry import face_areas
from stages.outfit.borders import loop_length
from stages.outfit.kinds import TYPES
from stages.outfit.own.load import load_own
from stages.outfit.own.placement import from_rest, measure, wearer
from stages.outfit.own.settings import ORIGINS, UNITS, UPS, OwnGarment
from stages.settings import SettingsError, build
from stages.spec import DataError


def main(arguments: Sequence[str]) -> int:
    """Runs one of the two commands; 0, or 65 with one line on stderr."""
    parser = argparse.ArgumentParser(prog="python -m stages.outfit", description="Garments of one's own.")
    commands = parser.add_subparsers(dest="command", required=True)
    body = commands.add_parser("body", help="write the body in its rest pose as an OBJ file, to place a garment on")
    check = commands.add_parser("check", help="say whether a garment can be worn, and what is wrong if it cannot")
    check.add_argument("--type", choices=TYPES, required=True, help="what it is most like")
    for command in (body, check):
        command.add_argument("file", type=Path)
        command.add_argument("--gender", choices=("female", "male"), default="female")
        command.add_argument("--betas", type=float, nargs="*", default=[], metavar="B", help="shape of the body")
        command.add_argument("--unit", choices=tuple(UNITS), default="m")
        command.add_argument("--up", choices=UPS, default="z")
        command.add_argument("--origin", choices=ORIGINS, default="root")
    given = parser.parse_args(arguments)
    told = {name: getattr(given, name) for name in ("gender", "betas", "unit", "up", "origin")}
    try:
        settings = build(
            OwnGarment, told | {"name": "garment", "file": str(given.file), "type": getattr(given, "type", "dress")}
        )
        if given.command == "body":
            write_body(given.file, settings)
        else:
            print("\n".join(describe(given.file, settings)))
    except (DataError, SettingsError) as error:
        print(error, file=sys.stderr)
        return 65
    except OSError as error:
        print(f"{given.file}: {error.strerror}; check the path and its rights", file=sys.stderr)
        return 65
    return 0


def write_body(path: Path, frame: OwnGarment) -> None:
    """Writes the body that a garment is placed on, in the unit, axes and origin of its file.

    Args:
        path: The OBJ file to write.
        frame: Says gender, betas, unit, up and origin.
    """
    body = wearer(frame.gender, frame.betas)
    points = from_rest(body.skin.vertices, frame.unit, frame.up, frame.origin, body.floor)
    facing = "-y" if frame.up == "z" else "z"
    lines = [f"# {frame.gender} body at rest, in {frame.unit}, {frame.up} up, facing {facing}, origin: {frame.origin}"]
    lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (body.skin.faces + 1).tolist()]
    path.write_text("\n".join([*lines, ""]))


def describe(path: Path, settings: OwnGarment) -> list[str]:
    """What is to be known of a garment that can be worn, line by line.

    Raises:
        DataError: It cannot be worn.
    """
    mesh = load_own(path.read_bytes(), settings, str(path))
    fit = measure(mesh.vertices, mesh.faces, settings.type, wearer(settings.gender, settings.betas))
    area = face_areas(mesh.vertices, mesh.faces).sum()
    borders = [f"{border.name} {loop_length(mesh.vertices, border.loop):.3f} m" for border in mesh.borders]
    return [
        f"{path}: can be worn",
        f"mesh: {len(mesh.vertices)} vertices, {len(mesh.faces)} triangles, edges {mesh.edge * 1e3:.1f} mm in the mean",
        f"area: {area:.3f} m^2",
        f"borders: {', '.join(borders)}",
        f"inside the body: {f'{fit.deepest * 1e3:.1f} mm at most, will be pushed out' if fit.deepest else 'nowhere'}",
    ]
