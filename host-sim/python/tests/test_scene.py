"""Scenes: the keys of scene files, their errors, copies and pickles."""

import copy
import pathlib
import pickle
import subprocess
import sys
import types

import cohold
import numpy as np
import pytest

SCENES = pathlib.Path(__file__).parents[3] / "scenes"


def test_a_name_a_file_and_its_text_are_one_scene(tmp_path):
    file = SCENES / "matched-line.toml"
    scene = cohold.Scene("matched-line")
    assert scene == cohold.Scene(file) == cohold.Scene(str(file)) == cohold.Scene.from_toml(file.read_text())
    assert scene != cohold.Scene()
    again = tmp_path / "again.toml"
    again.write_text(scene.to_toml())
    assert cohold.Scene(again) == scene == cohold.Scene(scene)
    assert eval(repr(scene), {"Scene": cohold.Scene}) == scene


def test_a_scene_is_read_like_a_mapping():
    scene = cohold.Scene("any-network")
    assert "network.loss" in scene and "no.key" not in scene and 3 not in scene
    assert scene.get("network.loss") == scene["network.loss"]
    assert scene.get("no.key") is None and scene.get("no.key", 1.5) == 1.5
    settings = dict(scene)
    assert list(scene) == list(settings) and len(scene) == len(settings) > 100
    assert cohold.Scene(settings=types.MappingProxyType(settings)) == scene


def test_a_name_is_a_scene_wherever_one_is_taken():
    name = "matched-line"
    scene = cohold.Scene(name)
    assert cohold.run(name, 0.1).state_hash == cohold.run(scene, 0.1).state_hash
    assert cohold.stability(name).spectral_radius == cohold.stability(scene).spectral_radius
    assert cohold.Pair(name).state_hash() == cohold.Pair(scene).state_hash()
    assert cohold.Pairs(name, 2).state_hashes() == cohold.Pairs(scene, 2).state_hashes()
    assert cohold.Peer(name, 1).state_hash() == cohold.Peer(scene, 1).state_hash()
    assert cohold.advice(name) == cohold.advice(scene)
    with pytest.raises(ValueError, match="no-scene"):
        cohold.run("no-scene")


def test_every_key_is_told_and_can_be_set_to_what_it_is():
    scene, keys = cohold.Scene(), cohold.keys()
    assert len(keys) > 100
    for key, about in keys.items():
        assert about["meaning"], key
        if about["default"] is not None:
            assert scene[key] == about["default"]
            scene[key] = about["default"]
    assert scene == cohold.Scene()
    assert keys["coordination.stiffness_n_per_m"]["unit"] == "N/m"
    assert "power" in keys["coordination.comm"]["allowed"]
    with pytest.raises(KeyError):
        scene["no.key"]


def test_values_of_python_and_numpy():
    scene = cohold.Scene()
    for key, value in {
        "network.loss": np.float32(0.25),
        "network.seed": np.int64(7),
        "contact.one_sided": np.True_,
        "coordination.comm": "power",
        "object.mass_kg": 1,
    }.items():
        scene[key] = value
        assert scene[key] == value
    with pytest.raises(TypeError, match="network.loss takes a bool, an int, a float or a str, not list"):
        scene["network.loss"] = [0.1]


@pytest.mark.parametrize(
    "key, value",
    [
        ("coordination.stiffness_n_per_m", -1),
        ("coordination.stiffness_n_per_m", "stiff"),
        ("coordination.comm", "powr"),
        ("coordination.stifness_n_per_m", 1),
        ("network.loss", 2),
        ("user.1.push_n", 5000),
        ("network.trace", "nowhere.csv"),
        ("nothing.at_all", 1),
    ],
)
def test_errors_are_the_command_lines(key, value, command_line):
    with pytest.raises(ValueError) as refused:
        cohold.Scene(None, {key: value})
    place, said = str(refused.value).split(": ", 1)
    told = command_line("cooperate", "--set", f"{key}={value}", fails=True)["error"]
    assert place == "scene" and said in told, told


def test_numbers_that_are_none_are_refused():
    for number in (float("nan"), float("inf")):
        with pytest.raises(ValueError, match="is not allowed"):
            cohold.Scene(None, {"network.loss": number})


def test_a_line_of_a_file_is_named(tmp_path):
    file = tmp_path / "wrong.toml"
    file.write_text("[network]\nloss = 0.1\nseed = -1\n")
    with pytest.raises(ValueError, match="wrong.toml:3: network.seed = -1 is not allowed"):
        cohold.Scene(file)
    with pytest.raises(ValueError, match=r"text:2: "):
        cohold.Scene.from_toml("[network]\nloss = = 1\n")
    with pytest.raises(FileNotFoundError) as missing:
        cohold.Scene(tmp_path / "none.toml")
    assert missing.value.filename == str(tmp_path / "none.toml") and missing.value.errno == 2
    with pytest.raises(ValueError, match="did you mean matched-line?"):
        cohold.Scene("matched-lin")


def test_a_combination_is_refused_when_it_is_used():
    scene = cohold.Scene(None, {"plant.winding": True})
    for use in (cohold.run, cohold.stability, cohold.Pair):
        with pytest.raises(ValueError, match="plant.winding = true is not allowed with plant.motor = false"):
            use(scene)


def test_copies_are_scenes_of_their_own():
    scene = cohold.Scene("any-network")
    for other in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert other == scene
        other["network.loss"] = 0.125
        assert other != scene


def test_a_pickle_names_its_traces_by_the_whole_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pathlib.Path("hand.csv").write_text("time_s,force_n\n0,0\n1,2\n2,0\n")
    scene = cohold.Scene(None, {"user.1.trace": "hand.csv"})
    run = cohold.run(scene, 2.0, every=0)
    code = "import pickle, sys, cohold; print(cohold.run(pickle.load(sys.stdin.buffer), 2.0, every=0).state_hash)"
    elsewhere = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(scene), capture_output=True, cwd="/", check=True)
    assert elsewhere.stdout.decode().strip() == run.state_hash
