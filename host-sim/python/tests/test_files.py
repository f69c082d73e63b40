"""pandas and Arrow read every table that the program writes, CSV and Parquet alike."""

import math
import pathlib

import pandas
import pyarrow.parquet


def same(csv: pathlib.Path) -> pandas.DataFrame:
    """Both files of a table hold the same: every number to the last bit."""
    told = pandas.read_csv(csv, keep_default_na=False, dtype=str)
    table = pyarrow.parquet.read_table(csv.with_suffix(".parquet"))
    frame = pandas.read_parquet(csv.with_suffix(".parquet"))
    assert list(told.columns) == table.column_names == list(frame.columns) and len(told) == len(frame) == table.num_rows > 0
    for name in told.columns:
        for text, value in zip(told[name], table[name].to_pylist()):
            if isinstance(value, str):
                assert text == value, name
            else:
                assert float(text or "nan") == value or (math.isnan(value) and text in ("", "NaN")), (name, text, value)
    return frame


def test_a_run(tmp_path, host_sim):
    files = host_sim("cooperate", "--scene", "matched-line", "--seconds", 1, "--out", tmp_path)["files"]
    csv = [pathlib.Path(file) for file in files if file.endswith(".csv")]
    for file in csv:
        same(file)
    assert len(csv) == 1
    made = pyarrow.parquet.read_schema(csv[0].with_suffix(".parquet")).metadata[b"made"].decode()
    assert 'number_type = "f64"' in made


def test_a_sweep_and_a_comparison(tmp_path, host_sim):
    over = ("--over", "coordination.stiffness_n_per_m=200..20000:4:log", "--over", "network.loss=0,0.2")
    host_sim("sweep", "--scene", "paper-5.2-wave-16ms", *over, "--seconds", 2, "--seeds", 2, "--out", tmp_path / "sweep")
    frame = same(tmp_path / "sweep" / "sweep.csv")
    assert len(frame) == 16 and frame[frame["stable"] == 0]["reason"].str.len().min() > 0
    rows = pandas.read_csv(tmp_path / "sweep" / "rows-1-of-1.csv")
    assert set(rows["state_hash"]) == set(frame["state_hash"])
    host_sim("compare", "wave", "passive-mean", "--seconds", 1, "--seeds", 2, "--out", tmp_path / "compare")
    csv = sorted((tmp_path / "compare").glob("*.csv"))
    assert len(csv) == 2
    for file in csv:
        same(file)


def test_a_recording(tmp_path, host_sim):
    record = tmp_path / "run.mcap"
    host_sim("cooperate", "--scene", "any-network", "--seconds", 1, "--record", record)
    host_sim("convert", record, tmp_path / "run.csv")
    host_sim("convert", record, tmp_path / "run.parquet")
    for csv in tmp_path.glob("*.csv"):
        same(csv)
    assert len(pandas.read_csv(tmp_path / "run.csv")) == 1000


def test_tables_of_a_study(tmp_path, host_sim):
    host_sim("paper", "--out", tmp_path)
    tables = list(tmp_path.rglob("*.csv"))
    assert tables
    for csv in tables:
        same(csv) if csv.with_suffix(".parquet").exists() else pandas.read_csv(csv)
