"""Sweeps: the command line's points, rows and folders."""

import pathlib
import pickle

import cohold
import numpy as np
import pyarrow.parquet
import pytest

SCENE = "paper-5.2-wave-16ms"
OVER = {"coordination.stiffness_n_per_m": "200..20000:6:log", "network.loss": [0, 0.2, 0.5]}
TYPED = ["--over", "coordination.stiffness_n_per_m=200..20000:6:log", "--over", "network.loss=0,0.2,0.5"]
TIMES = ["--seconds", 2, "--seeds", 2]


def asked(**other):
    return cohold.Sweep(SCENE, OVER, seconds=2.0, seeds=2, **other)


def same(table, parquet):
    """A table from Python and the command line's file of it, to the last bit."""
    there = pyarrow.parquet.read_table(parquet)
    assert list(table) == there.column_names
    for name, column in table.items():
        stored = there[name]
        if column.dtype == object:
            assert list(column) == stored.to_pylist(), name
        else:
            assert column.dtype == stored.to_numpy().dtype, name
            assert np.array_equal(column, stored.to_numpy(), equal_nan=column.dtype == float), name


def test_rows_are_the_command_lines(tmp_path, command_line):
    command_line("study", "sweep", "--scene", SCENE, *TYPED, *TIMES, "--out", tmp_path)
    table = asked().run()
    same(table, tmp_path / "sweep.parquet")
    assert len(table["seed"]) == 36 and 0 < table["stable"].sum() < 36
    failed = ~table["stable"]
    assert all(table["reason"][failed]) and not any(table["reason"][~failed])
    # Copies that came apart are said to be, and keep their figures.
    apart = np.array(["apart" in (reason or "") for reason in table["reason"]])
    assert (np.isnan(table["coordination_force_mean_n"]) == (failed & ~apart)).all()
    one, many = asked().run(threads=1), asked().run(threads=3)
    for name in table:
        assert np.array_equal(one[name], many[name], equal_nan=one[name].dtype == float), name


def test_a_sample_is_the_command_lines(tmp_path, command_line):
    drawn = {"network.loss": "0..0.3", "object.mass_kg": "0.02..1:log", "coordination.comm": ["wave", "passive-wave"]}
    for design in ("sobol", "latin-hypercube"):
        typed = [word for key, of in drawn.items() for word in ("--sample", f"{key}={of if isinstance(of, str) else ','.join(of)}")]
        folder = tmp_path / design
        more = ["--points", 8, "--design", design, "--sample-seed", 3, "--seconds", 1]
        command_line("study", "sweep", "--scene", SCENE, *typed, *more, "--out", folder)
        sweep = cohold.Sweep(SCENE, sample=drawn, points=8, design=design, sample_seed=3, seconds=1.0)
        same(sweep.run(), folder / "sweep.parquet")
        assert sweep.keys == list(drawn)


def test_a_folder_goes_on_whoever_began_it(tmp_path, command_line):
    command_line("study", "sweep", "--scene", SCENE, *TYPED, *TIMES, "--out", tmp_path, "--shard", "1/3")
    rows = tmp_path / "rows-1-of-3.csv"
    before = rows.read_text()
    sweep = asked()
    with sweep.open(tmp_path) as journal:
        missing = journal.missing()
        assert len(missing) == 12 and {point % 3 for point, _ in missing} == {1, 2}
        with pytest.raises(OSError, match="is being written by another process"):
            sweep.run(tmp_path)
        with pytest.raises(RuntimeError, match="12 points are not there yet"):
            journal.finish()
        journal.append(sweep.rows(missing[:5]))
    table = sweep.run(tmp_path)
    same(table, tmp_path / "sweep.parquet")
    assert rows.read_text() == before and len((tmp_path / "rows-1-of-1.csv").read_text().splitlines()) == 25
    told = command_line("study", "sweep", "--scene", SCENE, *TYPED, *TIMES, "--out", tmp_path)
    assert (told["runs"], told["new_runs"]) == (36, 0)
    with pytest.raises(OSError, match="is of another sweep"):
        cohold.Sweep(SCENE, OVER, seconds=1.0).run(tmp_path)


def test_a_point_has_its_scene_and_a_pickle_its_question():
    sweep = asked()
    assert (sweep.points, sweep.runs, sweep.seconds) == (18, 36, 2.0)
    point = sweep.scene_at(4)
    assert (point["network.loss"], point["network.seed"]) == (0.2, 1)
    again = pickle.loads(pickle.dumps(sweep))
    assert again.scene_at(17) == sweep.scene_at(17) and again.made == sweep.made
    assert again.rows([(3, [1])]) == sweep.rows([(3, [1])]) != sweep.rows([(4, [1])])
    with pytest.raises(ValueError, match="from 0 to 17"):
        sweep.scene_at(18)


@pytest.mark.parametrize(
    "arguments, says",
    [
        ({"over": {"network.los": [0, 1]}}, "there is no key network.los; did you mean network.loss?"),
        ({"over": {"network.loss": [0, 2]}}, "network.loss = 2 is not allowed: it must be a number from 0 to 0.95"),
        ({"over": {"network.loss": "0..1"}}, "write it as"),
        ({"over": {"network.seed": [1, 2]}}, "network.seed is no key to sweep over"),
        ({"over": {}}, "a sweep needs keys"),
        ({"sample": {"network.loss": "0..0.3"}}, "sample needs points"),
        ({"over": OVER, "points": 3}, "points is not allowed without sample"),
        ({"over": OVER, "seeds": 0}, "seeds = 0 is not allowed"),
        ({"over": OVER, "seconds": float("nan")}, "seconds = NaN is not allowed"),
        ({"sample": {"network.loss": "0..0.3"}, "points": 3, "design": "grid"}, 'one of "latin-hypercube", "sobol"'),
    ],
)
def test_what_cannot_be_swept_is_refused(arguments, says):
    with pytest.raises(ValueError) as refused:
        cohold.Sweep(SCENE, **arguments)
    assert says in str(refused.value)


def test_a_folder_that_cannot_be_written_is_an_os_error(tmp_path: pathlib.Path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(OSError, match="cannot make"):
        asked().run(file / "sweep")
