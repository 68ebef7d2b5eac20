"""Runs of the toy mill: only what is missing runs, every failure is one line, nothing published is lost."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from mill.bench import Mill

from pipeline.lock import locked


def test_a_run_makes_everything_once(mill: Mill) -> None:
    code, out, err = mill("run", "--jobs", "2")
    assert (code, err) == (0, "")
    assert "11 tasks published in" in out and f"report: {mill.output}" not in out
    made = mill.shards()
    assert len(made) == 8 + 2 + 2
    times = {path: path.stat().st_mtime_ns for path in mill.output.glob("*/*.h5")}
    assert mill("run") == (0, "nothing to do: 11 tasks up to date\n", "")
    assert {path: path.stat().st_mtime_ns for path in mill.output.glob("*/*.h5")} == times


def test_results_do_not_depend_on_jobs_or_place(mill: Mill, tmp_path: Path) -> None:
    mill("run", "--jobs", "2")
    made = mill.shards()
    mill.output = tmp_path / "other"
    mill("run", "--jobs", "1")
    assert mill.shards() == made


def test_until_and_only_make_that_and_what_it_needs(mill: Mill) -> None:
    assert mill("run", "--until", "weave", "--only", "one")[0] == 0
    assert sorted(mill.shards()) == ["weave/one.h5", "yarn/one.h5"]
    assert mill("run", "--until", "yarn")[0] == 0
    assert len(mill.shards()) == 9
    code, _, err = mill("run", "--only", "ome")
    assert code == 1 and err == f"{mill.recipe}: there is no item 'ome'; did you mean 'one'?\n"
    code, _, err = mill("status", "--until", "weav")
    assert code == 1 and err == "there is no stage 'weav'; did you mean 'weave'?\n"


def test_a_changed_setting_is_named_and_only_what_it_touches_runs(mill: Mill) -> None:
    mill("run")
    mill.recipe.write_text(mill.recipe.read_text() + "\n[weave]\nscale = 3\n")
    out = mill("status", "--why")[1]
    assert "weave/one: config.scale 2.0 -> 3.0\n" in out
    assert "bolt/all: input weave/one was made anew\n" in out
    assert "yarn/" not in out
    assert "3 tasks published" in mill("run")[1]


def test_status_counts(mill: Mill) -> None:
    table = mill("status")[1]
    assert "(2 sequences, 6 statics)" in table
    assert [line.split()[:4] for line in table.splitlines()[3:]] == [
        ["yarn", "-", "8", "-"],
        ["weave", "-", "2", "-"],
        ["bolt", "-", "1", "-"],
    ]
    assert "yarn/one: not made yet" in mill("status", "--why")[1]


def test_a_lost_shard_is_made_again_alike(mill: Mill) -> None:
    mill("run")
    made = mill.shards()
    (mill.output / "yarn" / "one.h5").unlink()
    assert "yarn/one: its shard is gone" in mill("status", "--why")[1]
    assert "1 task published" in mill("run")[1]
    assert mill.shards() == made


def test_lost_receipts_are_made_again_from_the_shards(mill: Mill) -> None:
    mill("run")
    kept = json.loads((mill.output / "yarn" / "receipts" / "one.json").read_text())
    for stage in ("yarn", "weave", "bolt"):
        shutil.rmtree(mill.output / stage / "receipts")
    assert mill("run")[1] == "nothing to do: 11 tasks up to date\n"
    again = json.loads((mill.output / "yarn" / "receipts" / "one.json").read_text())
    assert {name: again[name] for name in ("key", "document", "sha256")} == {
        name: kept[name] for name in ("key", "document", "sha256")
    }


def test_a_shard_that_was_only_touched_is_kept(mill: Mill) -> None:
    mill("run")
    (mill.output / "yarn" / "one.h5").touch()
    assert mill("run")[1] == "nothing to do: 11 tasks up to date\n"


@pytest.mark.parametrize("receipts", [True, False])
def test_a_damaged_shard_stops_run_and_status_before_use(mill: Mill, receipts: bool) -> None:
    mill("run")
    shard = mill.output / "yarn" / "one.h5"
    content = bytearray(shard.read_bytes())
    content[len(content) // 2 :] = bytes(len(content) - len(content) // 2)
    shard.write_bytes(content)
    (mill.output / "weave" / "one.h5").unlink()
    if not receipts:
        shutil.rmtree(mill.output / "yarn" / "receipts")
    made = mill.shards()
    command = f"python -m pipeline clean {mill.recipe} --output {mill.output} --stage yarn --only one"
    for name in ("run", "status"):
        code, _, err = mill(name)
        assert code == 1
        assert err.startswith(str(shard)) and err.endswith(f"remove it and make it again: {command}\n")
        assert err.count("\n") == 1
    assert mill.shards() == made
    assert mill("verify")[0] == 1
    assert mill(*command.split()[3:4], "--stage", "yarn", "--only", "one")[0] == 0
    assert mill("run")[0] == 0
    assert mill("verify") == (0, "11 of 11 shards verified, 0 at fault, 0 not there\n", "")


def test_an_older_shard_is_refused(mill: Mill) -> None:
    mill("run")
    with h5py.File(mill.output / "yarn" / "one.h5", "a") as file:
        file.attrs["schema_version"] = 0
    code, _, err = mill("run")
    assert code == 1 and "yarn/one.h5: schema train v0 where this program reads v1; remove it and make it again" in err


def test_damage_that_leaves_size_and_time_is_found_by_verify(mill: Mill) -> None:
    mill("run")
    page = mill.output / "bolt" / "all" / "index.html"
    page.write_text("other")
    code, out, err = mill("verify")
    assert code == 1 and "10 of 11 shards verified, 1 at fault" in out
    assert err.startswith(f"{page}: changed since it was published")


def test_bad_data_is_quarantined_and_never_retried(mill: Mill) -> None:
    mill.edit("length = 5", 'length = 5\nfault = "data"\nfaulty = ["one"]')
    for _ in range(2):
        code, out, _ = mill("run")
        assert code == 1
        assert "rejected: yarn/one: twist of the fibre is 7, must be < 5; take another fibre\n" in out
        assert "skipped: 2 tasks, waiting 2 for yarn/one" in out
    assert (mill.output / "yarn" / "one.tries").read_text() == "x"
    assert not (mill.output / "bolt" / "all").exists()
    assert "\nyarn/one: twist of the fibre is 7" in mill("status", "--why")[1]
    mill("clean", "--only", "one")
    mill("run")
    assert (mill.output / "yarn" / "one.tries").read_text() == "xx"


def test_tolerated_rejections_are_left_out_of_the_dataset(mill: Mill) -> None:
    mill.edit("statics = 6", "statics = 6\ntolerated_rejections = 0.2")
    mill.edit("length = 5", 'length = 5\nfault = "nan"\nfaulty = ["static_00002"]')
    code, out, _ = mill("run")
    assert code == 0 and "rejected: yarn/static_00002: " in out and "value at (1,) must be finite, got nan" in out
    page = (mill.output / "bolt" / "all" / "index.html").read_text()
    assert "static_00001" in page and "static_00002" not in page
    assert mill("run")[0] == 0
    assert "bolt" not in mill("status", "--why")[1].split("\n\n")[-1]


@pytest.mark.parametrize(
    ("fault", "tries", "message"),
    [
        ("error", 3, "failed: yarn/one: RuntimeError: the wheel broke; see "),
        ("crash", 3, "failed: yarn/one: its worker was ended by SIGSEGV; see "),
    ],
)
def test_failures_are_tried_three_times_and_the_rest_goes_on(mill: Mill, fault: str, tries: int, message: str) -> None:
    mill.edit("length = 5", f'length = 5\nfault = "{fault}"\nfaulty = ["one"]')
    code, out, _ = mill("run")
    assert code == 1 and message in out
    log = Path(out.split(message)[1].splitlines()[0])
    assert log.is_file()
    assert (mill.output / "yarn" / "one.tries").read_text() == "x" * tries
    assert (mill.output / "weave" / "two.h5").exists() and not (mill.output / "bolt" / "all").exists()
    if fault == "error":
        assert "Traceback" in log.read_text()


def test_an_interrupted_task_is_tried_again(mill: Mill) -> None:
    mill.edit("length = 5", 'length = 5\nfault = "transient"\nfaulty = ["one"]')
    assert mill("run")[0] == 0
    assert (mill.output / "yarn" / "one.tries").read_text() == "xxx"


def test_a_second_runner_is_refused(mill: Mill) -> None:
    with locked(mill.output):
        code, _, err = mill("run")
        assert code == 1 and err.startswith(f"{mill.output}: another runner works on it, pid ")
        assert mill("clean", "--only", "one")[0] == 1
        code, out, _ = mill("status")
        assert code == 0 and "a runner works on it: pid " in out


def test_one_task_runs_by_hand_and_leaves_its_receipt(mill: Mill) -> None:
    mill("run")
    made = mill.shards()
    mill("clean", "--stage", "yarn", "--only", "one")
    task = mill.output / "tasks" / "yarn" / "one.json"
    command = [sys.executable, "-m", "mill.yarn", "--task", str(task)]
    paths = {"PYTHONPATH": f"{mill.catalog.root()}:{Path(__file__).parents[2]}"}
    ended = subprocess.run(command, capture_output=True, text=True, env=paths)
    assert ended.returncode == 0, ended.stderr
    assert mill("run")[1] == "nothing to do: 11 tasks up to date\n"
    assert mill.shards() == made
    task.write_text(task.read_text().replace('"length": 5', '"length": 6'))
    ended = subprocess.run(command, capture_output=True, text=True, env=paths)
    assert ended.returncode == 1 and "the task was planned for other code" in ended.stderr
    ended = subprocess.run([*command[:-1], "none.json"], capture_output=True, text=True, env=paths)
    assert ended.returncode == 1 and "none.json: can't be read as a task" in ended.stderr


def test_a_full_disk_ends_the_run_and_loses_nothing(mill: Mill) -> None:
    """A limit on file sizes stands for the full disk; it is too small for a shard, and enough for task files."""
    mill("run", "--only", "two")
    made = mill.shards()
    code = (
        "import resource, sys; from mill.__main__ import load_catalog, main;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096));"
        "sys.exit(main(sys.argv[1:], load_catalog('mill', ('yarn', 'weave', 'bolt'))))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, "run", str(mill.recipe), "--output", str(mill.output)],
        capture_output=True,
        text=True,
        # Else the first import of a module leaves it compiled, cut off at the limit, for everybody after.
        env={"PYTHONPATH": f"{mill.catalog.root()}:{Path(__file__).parents[2]}", "PYTHONDONTWRITEBYTECODE": "1"},
    )
    assert ended.returncode == 74
    assert "no room to write it (File too large); free some space there and run again\n" in ended.stdout
    assert ended.stderr == ""
    assert mill.shards() == made and not list(mill.output.rglob("*.tmp"))
    assert mill("run")[0] == 0


def test_clean_wants_to_know_what(mill: Mill) -> None:
    code, _, err = mill("clean")
    assert code == 1 and err == "clean needs --only ID or --stage STAGE: it says what to remove\n"


def test_a_missing_motion_is_found_while_planning(mill: Mill) -> None:
    code, _, err = mill("run", "--motion", "none.bvh")
    assert code == 1 and err.endswith("none.bvh: No such file or directory; name an existing motion file\n")
    assert not mill.output.exists()
