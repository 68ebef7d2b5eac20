"""Bodies without hands or forearms for the cloth: sleeves end before what is missing, and the simulation takes them."""

from pathlib import Path

import numpy as np
import pytest

from model.body import REST_POSE, load_free_body
from stages.body.collision.segments import NAMES, segment
from stages.fabrics import load_fabrics
from stages.outfit import SPEC
from stages.outfit.bareness import LONGEST, for_body
from stages.outfit.config import Config
from stages.outfit.making import make_outfit
from stages.outfit.plan import draw_plan
from stages.outfit.stage import run
from stages.settings import plain
from stages.simulate.collider import refuse_covered
from stages.spec import DataError, Task
from store import publish, read

HANDS = ("left_hand", "right_hand")
FOREARMS = ("left_forearm", "left_hand")
WIDE = {"edge_length": 0.014, "sleeve_widening": (1.0, 1.0), "tightness_range": (-1.5, -1.5), "elastic_chance": 0.0}


def test_settings_stay_but_for_sleeves() -> None:
    config = Config(sleeve_length=(0.3, 1.0))
    assert for_body(config, ()) is config and for_body(config, ["right_upper_arm"]).sleeve_length == (0.3, 1.0)
    assert for_body(config, HANDS).sleeve_length == (0.3, LONGEST["hand"])
    assert for_body(config, FOREARMS).sleeve_length == (0.3, LONGEST["forearm"])
    assert for_body(Config(sleeve_length=(0.9, 1.0)), FOREARMS).sleeve_length == (0.37, 0.37)
    assert for_body(config, FOREARMS).leg_length == config.leg_length


@pytest.mark.parametrize(
    ("gender", "corner", "left_out", "longer"), [("female", -3.0, FOREARMS, 0.55), ("male", 3.0, HANDS, 1.0)]
)
def test_the_longest_sleeve_ends_before_what_is_missing(
    gender: str, corner: float, left_out: tuple[str, ...], longer: float
) -> None:
    """The widest sleeves, at a corner of shape space: taken at the limit, refused where they are longer."""
    model = load_free_body(gender)
    betas = np.random.default_rng(1).choice([-3.0, 3.0], 10)
    betas[:2] = corner
    faces, rest = model.faces, model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0]
    kept = ~np.isin(segment(model, betas).face_label, [NAMES.index(name) for name in left_out])
    limit = for_body(Config(**WIDE), left_out).sleeve_length[1]
    for length in (limit, longer):
        config = Config(**WIDE, sleeve_length=(length, length))
        plan = draw_plan("tshirt+trousers", config, np.random.default_rng(3))
        made = make_outfit(plan, model, betas, config, load_fabrics(), lambda label: None)
        garments = {garment.plan.name: garment.vertices for garment in made}
        if length == longer:
            with pytest.raises(DataError, match=r"tshirt: covers .* choose an outfit with shorter sleeves"):
                refuse_covered(left_out, garments, rest, faces, kept)
        else:
            refuse_covered(left_out, garments, rest, faces, kept)


def test_the_stage_records_it(tmp_path: Path) -> None:
    """The same seed on the same body: with its forearms the sleeves are long, without they are short."""
    model = load_free_body("female")
    rest = model.pose(np.zeros(10), REST_POSE[None], np.zeros((1, 3)))
    arrays = {"betas": np.zeros(10), "pose": REST_POSE[None], "trans": np.zeros((1, 3)), "rest_pose": REST_POSE}
    arrays |= {"faces": model.faces, "vertices": rest, "rest_vertices": rest[0]}
    attrs = {"gender": "female", "motion": "rest", "action": "rest", "fps": 30, "kind": "static"}
    reach = {}
    for name, left_out in (("whole", []), ("special", list(FOREARMS))):
        place = tmp_path / f"{name}.h5"
        publish(place, "body", "b" * 64, arrays, attrs | {"collision": {"left_out": left_out}})
        task = Task(
            stage="outfit",
            item="one",
            kind="static",
            key="a" * 64,
            seed=3,
            config=plain(Config(edge_length=0.014, sleeve_length=(0.8, 0.9))),
            params={"outfit": "tshirt+trousers"},
            inputs={"body": {"one": {"path": str(place), "key": "b" * 64}}},
            output=str(tmp_path / f"{name}_outfit.h5"),
        )
        run(task, lambda done, total, label="": None)
        shard = read(Path(task.output), SPEC.schema, "a" * 64)
        reach[name] = float(np.abs(shard["garments/tshirt/vertices"][:, 0]).max())
        assert shard.attrs.get("bare", {}).get("left_out", []) == left_out
    assert reach["special"] < 0.75 * reach["whole"]
