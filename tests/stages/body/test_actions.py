"""Action labels: from names and from free text to the paper's broad actions, and their table."""

import subprocess
import sys
from pathlib import Path

import pytest

from stages.body.actions import WORDS, action_of, broad_action, count_actions
from stages.body.statistics import main, table
from tests.stages.body.test_stage import ignore, run, task

PAPER = [
    "Walk",
    "Animal",
    "Fight",
    "Jump",
    "Run",
    "Sing",
    "Wait",
    "Swim",
    "Story",
    "Sports",
    "Dance",
    "Yoga",
    "Spin",
    "Exercise",
    "Climb",
    "Carry",
    "Stand",
    "Wash",
    "Balancing",
    "Trick",
    "Sit",
    "Interact",
    "Drink",
    "Pose",
]


def test_the_actions_are_the_paper_s() -> None:
    assert sorted(WORDS) == sorted(PAPER)


@pytest.mark.parametrize(
    ("label", "action"),
    [
        ("walk", "Walk"),
        ("walking_1", "Walk"),
        ("walk stealthily", "Walk"),
        ("zombie walk", "Walk"),
        ("run/jog", "Run"),
        ("playground - climb, hang, swing", "Climb"),
        ("basketball - forward dribble, 90-degree right turns", "Sports"),
        ("basketball_signal_1", "Sports"),
        ("directing_traffic_1", "Wait"),
        ("jumping_2", "Jump"),
        ("forward jump", "Jump"),
        ("modern dance", "Dance"),
        ("salsa", "Dance"),
        ("cartwheels", "Trick"),
        ("swimming", "Swim"),
        ("animal behaviors/pantomime - monkey", "Animal"),
        ("boxing", "Fight"),
        ("washing windows", "Wash"),
        ("vacuum floor", "Wash"),
        ("drinking soda", "Drink"),
        ("nursery rhyme - I'm a little teapot", "Sing"),
        ("yoga", "Yoga"),
        ("jumping jacks, side twists, bend over, squats", "Jump"),
        ("", "Others"),
        ("42", "Others"),
        ("gibberish", "Others"),
    ],
)
def test_labels_are_grouped(label: str, action: str) -> None:
    assert broad_action(label) == action


def test_a_name_tells_the_action() -> None:
    assert action_of("walking_22") == "walking" and action_of("directing_traffic_1") == "directing_traffic"
    assert action_of("01_01") == "01_01" and action_of("walk") == "walking"


def test_the_table_adds_up() -> None:
    rows = count_actions([("walk", 300), ("walking_2", 100), ("01_01", 500), ("salsa", 100)])
    assert rows == [("Walk", 2, 400), ("Dance", 1, 100), ("Others", 1, 500)]
    lines = table([("walk", 300), ("salsa", 100)]).splitlines()
    assert lines[1].split() == ["Walk", "1", "300", "75.00%"] and lines[-1].split() == ["all", "2", "400", "100.00%"]


def test_a_dataset_s_shards_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "set" / "body"
    folder.mkdir(parents=True)
    for kind, name in (("sequence", "someone"), ("static", "nobody")):
        run(task(folder, kind), ignore)
        (folder / "someone.h5").rename(folder / f"{name}_{kind}.h5")
    assert main([str(tmp_path / "set")]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == ["Walk", "1", "12", "100.00%"]
    (folder / "cut.h5").write_bytes((folder / "someone_sequence.h5").read_bytes()[:5000])
    assert main([str(folder)]) == 1
    assert "cut.h5" in capsys.readouterr().err
    assert main([str(tmp_path)]) == 1


def test_it_is_one_command(tmp_path: Path) -> None:
    ran = subprocess.run(
        [sys.executable, "-m", "stages.body", "statistics", str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 1 and ran.stderr.count("\n") == 1 and "there are no bodies in motion" in ran.stderr
