"""The dataset section -> items: one sequence or one static person each, with all that a stage may ask about it."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipeline.dataset import Dataset, SequenceEntry
from pipeline.errors import PipelineError
from pipeline.labels import Labels, read_labels
from pipeline.motion import MotionFiles, file_of
from stages.spec import DataError

DATASET_ITEM = "all"  # the item of stages that run once, over every item


@dataclass(frozen=True)
class Item:
    """One sequence or one static person.

    Attributes:
        id: Name, unique in the dataset.
        kind: "sequence" or "static".
        params: gender, outfit, split; for sequences also motion, motion_sha256, start and frames (at 30 fps), and
            action if a list of labels tells it.
    """

    id: str
    kind: str
    params: dict[str, Any]


def collect(
    dataset: Dataset, where: str, motion_files: MotionFiles, *, motion: Path | None = None, frames: int | None = None
) -> list[Item]:
    """Every item of `dataset`: sequences first, since they take longest.

    Args:
        dataset: The recipe's section.
        where: The section's place, for messages.
        motion_files: Reader of motion files.
        motion: A motion file that replaces every sequence's motion.
        frames: Length that replaces every given sequence's own [frames].

    Raises:
        PipelineError: A motion that can't be used, or a bad or repeated id; one line.
    """
    entries = [replace(entry, frames=frames or entry.frames) for entry in dataset.sequence]
    if dataset.sequences:
        entries += _drawn(dataset, where, motion_files)
    if motion is not None:
        entries = [replace(entry, motion=str(motion), start=0) for entry in entries]
    labels = read_labels(dataset.labels, where)
    sequences = [_sequence(entry, f"{where} sequence {entry.id!r}", motion_files, labels) for entry in entries]
    statics = [_static(dataset, index) for index in range(dataset.statics)]
    _check_ids([*sequences, *statics], where)
    for kind in (sequences, statics):
        _split(dataset, kind)
    return [*sequences, *statics]


def is_file(motion: str) -> bool:
    """Whether `motion` names a file; a bare word names an embedded motion."""
    return "/" in motion or file_of(Path(motion)).suffix.lower() in (".bvh", ".amc", ".npz", ".txt")


def _sequence(entry: SequenceEntry, where: str, motion_files: MotionFiles, labels: Labels) -> Item:
    params: dict[str, Any] = {"gender": entry.gender, "outfit": entry.outfit, "split": entry.split}
    params |= {"motion": entry.motion, "motion_sha256": "", "start": entry.start, "frames": entry.frames}
    if is_file(entry.motion):
        found = motion_files(entry.motion, where)
        if entry.start >= found.frames:
            limit = f"{found.frames} frames, the length of {found.path} at 30 fps"
            raise PipelineError(f"{where}: start must be < {limit}, got {entry.start}")
        params |= {"motion": str(found.path), "motion_sha256": found.sha256}
        params["frames"] = min(entry.frames, found.frames - entry.start)
        if label := labels.of(str(found.path)):
            params["action"] = label
    return Item(entry.id, "sequence", params)


def _static(dataset: Dataset, index: int) -> Item:
    # In turn, not at random: a small set then has every outfit for both genders in the right shares.
    turn, place = divmod(index, len(dataset.outfits))
    share = dataset.female_share
    female = int((turn + 1) * share + 0.5) > int(turn * share + 0.5)
    params = {"gender": "female" if female else "male", "outfit": dataset.outfits[place], "split": ""}
    return Item(f"static_{index:05d}", "static", params)


def _drawn(dataset: Dataset, where: str, motion_files: MotionFiles) -> list[SequenceEntry]:
    """Cut every clip into pieces and take as many as asked for, in an order that is random and yet each piece's own:
    a clip that is added or removed leaves the other choices alone."""
    pieces: list[tuple[str, str, int, int]] = []
    for name, path in _clips(dataset.motions, where):
        found = motion_files(path, where)
        for number, start in enumerate(range(0, found.frames, dataset.frames)):
            frames = min(dataset.frames, found.frames - start)
            if frames >= dataset.shortest:
                pieces.append((f"{name}_s{number}", path, start, frames))
    if not pieces:
        raise PipelineError(f"{where}: motions = {dataset.motions!r} has no clip of {dataset.shortest} frames or more")
    pieces.sort(key=lambda piece: _chance(dataset.seed, "order", piece[0]))
    entries = []
    for index in range(dataset.sequences):
        turn, place = divmod(index, len(pieces))
        name, motion, start, frames = pieces[place]
        name = f"{name}_p{turn}" if turn else name  # the same motion by another person in another outfit
        gender = "female" if _chance(dataset.seed, "gender", name) < dataset.female_share else "male"
        outfit = dataset.outfits[int(_chance(dataset.seed, "outfit", name) * len(dataset.outfits))]
        entries.append(SequenceEntry(id=name, gender=gender, motion=motion, outfit=outfit, start=start, frames=frames))
    return entries


def _clips(motions: str, where: str) -> list[tuple[str, str]]:
    """Names and paths of all motions in a folder or of a pattern; an .npz file may hold many, or none."""
    from stages.body.readers.survey import motions_in, title

    folder = Path(motions).expanduser()
    if folder.is_dir():
        found = folder.glob("**/*")
    elif any(sign in motions for sign in "*?["):
        base = Path(folder.anchor) if folder.is_absolute() else Path()
        found = base.glob(str(folder.relative_to(folder.anchor) if folder.is_absolute() else folder))
    else:
        kinds = "name a folder of motion files or a pattern"
        raise PipelineError(f"{where}: motions = {motions!r}: no such folder; {kinds}")
    try:
        clips = [clip for path in sorted(found) if path.is_file() for clip in motions_in(path)]
    except DataError as error:
        raise PipelineError(f"{where}: motions = {motions!r}: {error}") from None
    if not clips:
        kinds = "name a folder of BVH, AMC or npz files, or a pattern"
        raise PipelineError(f"{where}: motions = {motions!r} has no motion files; {kinds}")
    names = Counter(title(clip) for clip in clips)
    ids = [_id(clip, title(clip), names[title(clip)] > 1) for clip in clips]
    shared = Counter(ids)
    return [(f"{name}_{_mark(clip)}" if shared[name] > 1 else name, clip) for name, clip in zip(ids, clips)]


def _mark(clip: str) -> str:
    """Tells motions apart whose ids would be the same, as those of names in scripts without a letter of ours."""
    return hashlib.sha256("/".join(Path(clip).parts[-3:]).encode("utf-8", "surrogateescape")).hexdigest()[:8]


def _id(clip: str, name: str, shared: bool) -> str:
    """A motion's name as an id has it; if several files share it, with their folder's name before it."""
    full = f"{Path(clip).parent.name}_{name}" if shared else name
    return re.sub(r"[^A-Za-z0-9_.\-]", "_", full)


def _split(dataset: Dataset, items: list[Item]) -> None:
    """Mark `test_share` of the items without a part of their own as "test", the others as "train"."""
    drawn = sorted(
        (item for item in items if not item.params["split"]), key=lambda i: _chance(dataset.seed, "split", i.id)
    )
    tests = round(len(drawn) * dataset.test_share)
    for rank, item in enumerate(drawn):
        item.params["split"] = "test" if rank < tests else "train"


def _check_ids(items: Iterable[Item], where: str) -> None:
    seen: set[str] = set()
    for item in items:
        if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.\-]*", item.id) or item.id == DATASET_ITEM:
            raise PipelineError(
                f"{where}: id must be of letters, digits, '_', '-' and '.', and not {DATASET_ITEM!r}, got {item.id!r}"
            )
        if item.id in seen:
            raise PipelineError(f"{where}: id {item.id!r} stands there twice; give each item its own")
        seen.add(item.id)


def _chance(seed: int, choice: str, name: str) -> float:
    """A number in [0, 1) that depends on the seed, the choice to make and the item's name alone."""
    digest = hashlib.sha256(f"{seed}/{choice}/{name}".encode()).digest()
    return int.from_bytes(digest[:6], "little") / 2**48
