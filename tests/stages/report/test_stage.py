"""The stage on shards made by hand: a full folder, links that resolve, nothing from elsewhere, equal bytes again."""

import re
from html.parser import HTMLParser
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

import store
from stages.report.film import write_film
from stages.report.gather import spread
from stages.report.stage import run
from stages.spec import Task, load_spec

FRAMES = 5
SIZE = {"picture_width": 64, "picture_height": 96, "strip_frames": 3, "statics": 2}
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
BOX_FACES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))], dtype=np.int32)
BOX = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.1, 0.1) for z in (-0.9, 0.8)], dtype=np.float32)
CAPE = np.array([[-0.15, 0.15, 0.7], [0.15, 0.15, 0.7], [0.15, 0.15, 0.0], [-0.15, 0.15, 0.0]], dtype=np.float32)
CAPE_FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
UPRIGHT = np.array([0.5 * np.pi, 0.0, 0.0], dtype=np.float32)


def publish_item(folder, item, kind, inputs, depth=0.0):
    """Publishes a box that wears a cape; the cape's lower edge is `depth` inside the box in the last frame."""
    frames = FRAMES if kind == "sequence" else 1
    pose = np.zeros((frames, 24, 3), dtype=np.float32)
    pose[:, 0] = UPRIGHT
    trans = np.zeros((frames, 3), dtype=np.float32)
    trans[:, 1], trans[:, 2] = -0.1 * np.arange(frames), 0.9
    body = {
        "betas": np.zeros(10, dtype=np.float32),
        "pose": pose,
        "trans": trans,
        "rest_pose": pose[0],
        "faces": BOX_FACES,
        "vertices": np.repeat(BOX[None], frames, axis=0),
        "rest_vertices": BOX,
    }
    publish(
        folder, "body", item, body, {"gender": "female", "motion": "m", "action": "a", "fps": 30, "kind": kind}, inputs
    )
    garments = {"cape": {"type": "top", "fabric": {"name": "silk"}, "parameters": {}, "elastics": {}}}
    outfit = {
        "tight_betas": np.zeros(10, dtype=np.float32),
        "garments/cape/vertices": CAPE,
        "garments/cape/faces": CAPE_FACES,
        "garments/cape/elastic": np.zeros(4, dtype=np.int8),
        "garments/cape/waistband": np.zeros(4, dtype=bool),
    }
    about = {"kind": "dress", "gender": "female", "tightness": [0.0, 0.5], "garments": garments, "layers": ["cape"]}
    publish(folder, "outfit", item, outfit, about, inputs)
    if kind == "sequence":
        moving = np.repeat(CAPE[None], frames, axis=0)
        moving[-1, 2:, 1] = 0.1 - depth if depth else 0.15
        cloth = {"garments/cape/vertices": moving, "garments/cape/faces": CAPE_FACES}
        quality = {"steps": 77, "step_error_rms_m": 1.5e-4}
        publish(folder, "simulate", item, cloth, {"fps": 30, "garments": garments, "quality": quality}, inputs)


def publish(folder, stage, item, arrays, attrs, inputs):
    path = folder / stage / f"{item}.h5"
    store.publish(path, stage, "k" * 64, arrays, attrs)
    inputs[stage][item] = {"path": str(path), "key": "k" * 64}


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    """A task over two sequences, of which the second is bad, and three outfits at rest."""
    folder = tmp_path_factory.mktemp("shards")
    inputs = {"body": {}, "outfit": {}, "simulate": {}, "train": {}}
    publish_item(folder, "seq_good", "sequence", inputs)
    publish_item(folder, "seq_deep", "sequence", inputs, depth=0.02)
    for n in range(3):
        publish_item(folder, f"still_{n}", "static", inputs)
    made = {"vertices": CAPE, "faces": CAPE_FACES, "body_vertices": BOX, "body_faces": BOX_FACES}
    row = {"model": "<SVAE>", "set": "static", "held_out": True, "items": 3, "surface_mm": 4.5}
    publish(
        folder,
        "train",
        "all",
        {f"generated/g0/{name}": array for name, array in made.items()},
        {"metrics": [row], "losses": {"svae": {"step": [1, 2, 3], "total": [3.0, 2.0, 1.0]}}},
        inputs,
    )
    return Task(
        stage="report",
        item="all",
        kind="dataset",
        key="r" * 64,
        seed=1,
        config=SIZE,
        params={},
        inputs=inputs,
        output=str(folder / "report"),
    )


@pytest.fixture(scope="module")
def report(task):
    """The published folder and what the stage returned, with the progress it told."""
    told = []
    figures = run(task, lambda done, total, label="": told.append((done, total, label)))
    return Path(task.output), figures, told


class Links(HTMLParser):
    """Collects what a page refers to."""

    def __init__(self):
        super().__init__()
        self.files, self.anchors, self.ids, self.tags = [], [], set(), []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.add(value)
            elif name in ("src", "href", "poster", "xlink:href", "srcset", "data"):
                (self.anchors if value.startswith("#") else self.files).append(value)


def links_of(folder):
    found = Links()
    found.feed((folder / "index.html").read_text())
    return found


def test_every_link_resolves_and_every_file_is_linked(report):
    folder = report[0]
    found = links_of(folder)
    published = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert set(found.files) == published - {"index.html", "key.json"}
    assert {anchor[1:] for anchor in found.anchors} <= found.ids
    assert found.tags.count("video") == 2


def test_page_needs_no_network(report):
    text = (report[0] / "index.html").read_text()
    assert not re.search(r"https?:|//[a-z]|@import|url\((?!#)", text)
    assert not {"script", "link", "iframe"} & set(links_of(report[0]).tags)


def test_page_escapes_text_from_shards(report):
    assert "&lt;SVAE&gt;" in (report[0] / "index.html").read_text()


def test_video_has_all_frames_and_both_views(report):
    path = report[0] / "sequences" / "seq_good.mp4"
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames == FRAMES
    assert seconds == pytest.approx(FRAMES / 30, abs=0.01)
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    reader.close()
    assert about["size"] == (128, 96)
    assert about["codec"] == "h264"
    assert about["pix_fmt"].startswith("yuv420p")


def test_strip_shows_the_frames_asked_for(report):
    with Image.open(report[0] / "sequences" / "seq_good-strip.jpg") as strip:
        assert strip.size == (3 * 64, 96)


def test_figures_and_badges_tell_the_good_from_the_bad(report):
    folder, figures, _ = report
    assert figures == {"sequences": 2, "good": 1}
    text = (folder / "index.html").read_text()
    deep, good = text.index('id="seq_deep"'), text.index('id="seq_good"')
    assert deep < good
    assert 'class="fail"' in text[deep:good]
    assert "20.00 mm" in text[deep:good]
    assert 'class="fail"' not in text[good:]
    assert "77" in text[good:]
    assert re.search(r"error bar of the step, rms\W.{0,40}0\.15 mm", text[good:], re.DOTALL)


def test_progress_rises_to_the_total(report):
    done = [told[0] for told in report[2]]
    assert done == sorted(done)
    assert done[-1] == report[2][-1][1]


def test_report_has_equal_bytes_again(report, task, tmp_path):
    again = Task(**{**vars(task), "output": str(tmp_path / "again")})
    run(again, lambda done, total, label="": None)
    first, second = Path(task.output), Path(again.output)
    assert (first / "key.json").read_bytes() == (second / "key.json").read_bytes()
    store.folder.read_folder(second, "r" * 64)


def test_report_of_no_sequences_is_still_a_page(task, tmp_path):
    alone = {**task.inputs, "simulate": {}}
    few = {**SIZE, "statics": 1}
    run(
        Task(**{**vars(task), "inputs": alone, "config": few, "output": str(tmp_path / "r")}),
        lambda done, total, label="": None,
    )
    assert "video" not in links_of(tmp_path / "r").tags


def test_film_refuses_odd_sizes(tmp_path):
    with pytest.raises(ValueError, match="even, got 63 x 96 px"):
        write_film(tmp_path / "odd.mp4", [], 63, 96, 30)


def test_items_shown_are_spread_over_the_dataset():
    assert spread(list("abcdefghi"), 3) == ["a", "e", "i"]
    assert spread(list("ab"), 5) == ["a", "b"]
    assert spread([], 5) == []
    assert spread(list("abc"), 0) == []


def test_spec_is_a_folder_over_the_dataset():
    spec = load_spec("report")
    assert (spec.scope, spec.suffix, spec.schema) == ("dataset", "", "report")
