"""Studies: the command line's points, rows, answers and folders."""

import cohold
import numpy as np
import pyarrow.parquet
import pytest
from test_sweep import same

LAWS = ["wave", "power,coordination.damping_n_s_per_m=3"]
OVER = {"coordination.stiffness_n_per_m": "300..30000:3:log"}
NETWORKS = ["own", "loss 20 %"]
TYPED = ["--over", "coordination.stiffness_n_per_m=300..30000:3:log", "--network", "own", "--network", "loss-20-%"]
TIMES = ["--seconds", 2, "--seeds", 4]


def asked(**other):
    return cohold.Study(LAWS, OVER, networks=NETWORKS, seeds=4, seconds=2.0, **other)


def test_rows_and_answers_are_the_command_lines(tmp_path, command_line):
    bound = ["--at-most", "peak_coordination_force_n=3"]
    command_line("study", *LAWS, *TYPED, *TIMES, *bound, "--out", tmp_path)
    found = asked().run()
    same(found.rows, tmp_path / "study.parquet")
    same(found.points, tmp_path / "study-points.parquet")
    at_most = {"peak_coordination_force_n": 3.0}
    same(found.best(at_most=at_most), tmp_path / "study-best.parquet")
    same(found.pairs(at_most=at_most), tmp_path / "study-pairs.parquet")
    assert len(found.rows["seed"]) == 48 and 0 < found.rows["every_mode_stable"].sum() < 48


def test_the_best_point_is_that_of_the_rows():
    """From the rows alone: the first two seeds choose among points that may be taken, the other two judge."""
    found = asked().run()
    rows, told = found.rows, found.best()
    merit, seed = rows["true_discrepancy_mm"], rows["seed"]
    for at, (entrant, network) in enumerate(zip(told["entrant"], told["network_name"])):
        here = (rows["entrant"] == entrant) & (rows["network_name"] == network)
        allowed = {}
        for gain in np.unique(rows["coordination.stiffness_n_per_m"][here]):
            point = here & (rows["coordination.stiffness_n_per_m"] == gain)
            if (rows["stable"] & rows["every_mode_stable"])[point].all():
                allowed[gain] = (merit[point & (seed <= 2)].mean(), merit[point & (seed > 2)].mean())
        assert told["allowed_points"][at] == len(allowed)
        if allowed:
            gain = min(allowed, key=lambda gain: allowed[gain][0])
            assert told["coordination.stiffness_n_per_m"][at] == gain
            assert told["mean"][at] == pytest.approx(allowed[gain][1], rel=1e-12)


def test_a_folder_goes_on_and_a_figure_is_drawn(tmp_path, command_line):
    command_line("study", *LAWS, *TYPED, *TIMES, "--out", tmp_path, "--shard", "1/2")
    done = []
    found = asked().run(tmp_path, progress=lambda at, total: done.append(total))
    assert set(done) == {24} and pyarrow.parquet.read_table(tmp_path / "study.parquet").num_rows == 48
    paths = found.draw(tmp_path / "figure")
    # As the command line names it.
    assert {path.stem for path in paths if path.suffix in (".svg", ".pdf", ".png")} == {"study-best"}
    assert {path.suffix for path in paths} == {".svg", ".pdf", ".png", ".toml"}
    scenes = {"soft": cohold.Scene("any-network", {"user.1.push_n": 1.0}), "as it is": "any-network"}
    assert cohold.Study(scenes, seeds=2, seconds=1.0).points == 2
    with pytest.raises(OSError, match="is of another study"):
        cohold.Study(LAWS, OVER, seconds=1.0).run(tmp_path)


def test_a_search_is_the_command_lines_and_the_grids(tmp_path, command_line):
    """Fewer runs, and the grid's best points; the folder is one for both, and another question than the searched one is refused."""
    most = {"peak_hand_force_n": 3.0}
    command_line("study", *LAWS, *TYPED, *TIMES, "--at-most", "peak_hand_force_n=3", "--search", "halving", "--out", tmp_path)
    found = asked().run(search="halving", at_most=most)
    same(found.rows, tmp_path / "study.parquet")
    same(found.best(at_most=most), tmp_path / "study-best.parquet")
    same(found.pairs(at_most=most), tmp_path / "study-pairs.parquet")
    assert len(found.rows["seed"]) < 48
    # What is not stable in every mode was not run, and says so.
    unrun = found.points["runs"] == 0
    assert unrun.any() and not found.points["every_mode_stable"][unrun].any()
    assert all(reason.startswith("not run: ") for reason in found.points["reason"][unrun])
    again = asked().run(tmp_path, search="halving", at_most=most)
    assert np.array_equal(again.rows["state_hash"], found.rows["state_hash"])
    grid = asked().run(tmp_path)
    assert len(grid.rows["seed"]) == 48
    for name in ("entrant", "network_name", "coordination.stiffness_n_per_m", "mean", "seeds"):
        np.testing.assert_array_equal(grid.best(at_most=most)[name], found.best(at_most=most)[name], name)
    with pytest.raises(ValueError, match="the runs decide the least true_discrepancy_mm, peak_hand_force_n at most 3 in any run, not"):
        found.best()
    with pytest.raises(ValueError, match=r'search = "race" is not allowed: it must be one of \["grid", "halving"\]'):
        asked().run(search="race")


@pytest.mark.parametrize(
    "entrants, arguments, says",
    [
        (["wafe"], {}, "the laws are power, p-plus-d, wave,"),
        (["wave,object.mas_kg=1"], {}, "did you mean object.mass_kg?"),
        (["wave"], {"networks": "los 5 %"}, 'did you mean "loss 5 %"?'),
        (["wave"], {"networks": ["loss 5 %"], "over": {"network.loss": [0, 0.1]}}, 'the network "loss 5 %" rules it'),
        (["wave", "wave"], {}, "wave takes part twice"),
        ([], {}, "a study needs a scene or law"),
    ],
)
def test_what_cannot_be_asked_is_refused(entrants, arguments, says):
    with pytest.raises(ValueError) as refused:
        cohold.Study(entrants, **arguments)
    assert says in str(refused.value)
    with pytest.raises(ValueError, match="they are true_discrepancy_mm"):
        cohold.Study(["wave"], seeds=1, seconds=0.1).run().best("force")
