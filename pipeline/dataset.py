"""The recipe's section `[dataset]`: which people, motions and outfits there are."""

from __future__ import annotations

from dataclasses import dataclass, field

from stages.outfit.kinds import KINDS as OUTFITS
from stages.outfit.kinds import worn
from stages.outfit.own.settings import OwnGarment

GENDERS = ("female", "male")


@dataclass(frozen=True, kw_only=True)
class SequenceEntry:
    """One `[[dataset.sequence]]`: a person, a motion and an outfit."""

    id: str
    """Name of the item: letters, digits, `_`, `-` and `.`."""
    gender: str = field(metadata={"choices": GENDERS})
    """Gender of the body."""
    motion: str
    """Name of an embedded motion, or path of a motion file: BVH, AMC, npz (`file.npz:sequence` for one of many)."""
    outfit: str = "random"
    """Kind of outfit; or garments joined by `+`, the outer first, of which one at least is one's own."""
    start: int = field(default=0, metadata={"ge": 0})
    """First frame of the motion, at 30 fps [frames]."""
    frames: int = field(default=60, metadata={"ge": 1})
    """Number of frames, at 30 fps [frames]."""
    split: str = field(default="", metadata={"choices": ("", "train", "test")})
    """Part of the dataset; left out, it is drawn."""


@dataclass(frozen=True, kw_only=True)
class BodyModels:
    """The recipe's section `[dataset.body_models]`: whose bodies, if not the embedded free one's."""

    female: str = ""
    """Path of a file of SMPL, SMPL-H or SMPL-X for women; the free body if left out."""
    male: str = ""
    """Path of a file of SMPL, SMPL-H or SMPL-X for men; the free body if left out."""


@dataclass(frozen=True, kw_only=True)
class Dataset:
    """What the dataset consists of; every random choice follows from `seed` and the item's id alone."""

    name: str
    """Name of the dataset."""
    output: str = ""
    """Folder for everything made; `build/<name>` if left out."""
    seed: int = field(default=0, metadata={"ge": 0})
    """Seed of every random choice."""
    body_models: BodyModels = field(default_factory=BodyModels)
    """Files of the body models."""
    sequence: tuple[SequenceEntry, ...] = ()
    """Sequences given one by one."""
    sequences: int = field(default=0, metadata={"ge": 0})
    """Number of sequences to draw from `motions`, besides those given."""
    motions: str = ""
    """Folder of motion files, or a pattern such as `motion/*_walk.bvh`."""
    labels: str = ""
    """File that tells the actions of motions, such as CMU's index: in each line a motion's name, then its label."""
    frames: int = field(default=300, metadata={"ge": 1})
    """Length of a drawn sequence, at 30 fps [frames]; a clip is cut into as many as it has, the last one shorter."""
    shortest: int = field(default=30, metadata={"ge": 1})
    """Shortest rest of a clip that is kept as a sequence [frames]."""
    statics: int = field(default=0, metadata={"ge": 0})
    """Number of static people: in rest pose, for the static model."""
    female_share: float = field(default=0.5, metadata={"ge": 0, "le": 1})
    """Share of female bodies among drawn items [1]."""
    outfits: tuple[str, ...] = OUTFITS
    """Kinds of outfit that drawn items wear, own garments among them if they are named here."""
    garment: tuple[OwnGarment, ...] = ()
    """Garments of one's own."""
    fabrics: str = ""
    """File of further fabrics, in the form of `stages/fabrics.toml`."""
    test_share: float = field(default=0.2, metadata={"ge": 0, "lt": 1})
    """Share of each kind of item that is held out for testing [1]."""
    tolerated_rejections: float = field(default=0.0, metadata={"ge": 0, "lt": 1})
    """Share of items that may be rejected for bad data before the dataset isn't trained on any more [1]."""

    def __post_init__(self) -> None:
        if not self.sequence and not self.sequences and not self.statics:
            raise ValueError("there are no items: give [[dataset.sequence]], sequences and motions, or statics")
        if self.sequences and not self.motions:
            raise ValueError(f"motions is missing: sequences = {self.sequences} are drawn from motion files")
        if not self.outfits:
            raise ValueError("outfits must name one kind at least, got []")
        own = [garment.name for garment in self.garment]
        for name in own:
            if own.count(name) > 1:
                raise ValueError(f"garment: name {name!r} stands there twice; give each garment its own")
        for kind in self.outfits:
            worn(kind, own)
        for entry in self.sequence:
            if entry.outfit != "random":
                try:
                    worn(entry.outfit, own)
                except ValueError as error:
                    raise ValueError(f"sequence {entry.id!r}: {error}") from None
