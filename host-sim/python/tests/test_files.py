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
            if value is None:
                assert text == "", name
            elif isinstance(value, str):
                assert text == value, name
            else:
                assert float(text) == value or (math.isnan(value) and text == "NaN"), (name, text, value)
    return frame


def test_a_run(tmp_path, command_line):
    files = command_line("cooperate", "--scene", "matched-line", "--seconds", 1, "--out", tmp_path)["files"]
    csv = [pathlib.Path(file) for file in files if file.endswith(".csv")]
    for file in csv:
        same(file)
    assert len(csv) == 1
    made = pyarrow.parquet.read_schema(csv[0].with_suffix(".parquet")).metadata[b"made"].decode()
    assert 'number_type = "f64"' in made


def test_a_sweep(tmp_path, command_line):
    over = ("--over", "coordination.stiffness_n_per_m=200..20000:4:log", "--over", "network.loss=0,0.2")
    command_line("study", "sweep", "--scene", "paper-5.2-wave-16ms", *over, "--seconds", 2, "--seeds", 2, "--out", tmp_path / "sweep")
    frame = same(tmp_path / "sweep" / "sweep.csv")
    assert len(frame) == 16 and frame[frame["stable"] == 0]["reason"].str.len().min() > 0
    rows = pandas.read_csv(tmp_path / "sweep" / "rows-1-of-1.csv")
    assert set(rows["state_hash"]) == set(frame["state_hash"])


def test_a_recording(tmp_path, command_line):
    record = tmp_path / "run.mcap"
    command_line("cooperate", "--scene", "any-network", "--seconds", 1, "--record", record)
    command_line("recording", "convert", record, tmp_path / "run.csv")
    command_line("recording", "convert", record, tmp_path / "run.parquet")
    for csv in tmp_path.glob("*.csv"):
        same(csv)
    assert len(pandas.read_csv(tmp_path / "run.csv")) == 1000


def test_tables_of_a_study(tmp_path, command_line):
    command_line("paper", "--out", tmp_path)
    tables = list(tmp_path.rglob("*.csv"))
    assert tables
    for csv in tables:
        same(csv) if csv.with_suffix(".parquet").exists() else pandas.read_csv(csv)


def types(parquet: pathlib.Path) -> dict[str, str]:
    """What Arrow reads each column of a file as."""
    return {field.name: str(field.type) for field in pyarrow.parquet.read_schema(parquet)}


RUN = {"seed": "int64", "stable": "bool", "verdict": "string", "reason": "string", "spectral_radius": "double", "unstable_modes": "string"}
MERITS = {"true_discrepancy_mm": "double", "peer_energy_made_mj": "double", "state_hash": "string"}
KEYS = {"coordination.stiffness_n_per_m": "double", "network.one_way_delay_packets": "int64", "coordination.ledger": "bool"}
BEST = {"entrant": "string", "mean": "double", "mean_95": "double", "seeds": "int64", "as_good_points": "int64", "as_good_from": "double",
        "next": "string", "next_difference": "double", "next_judged": "bool", "points": "int64", "reason": "string"}
PAIRS = {"network_name": "string", "common_networks": "int64", "difference": "double", "differs": "bool", "without": "string"}
POINTS = {"runs": "int64", "every_mode_stable": "bool", "unstable_modes": "string", "true_discrepancy_mm": "double", "reason": "string"}


def test_a_column_is_what_it_is_declared_as_where_nothing_failed_and_where_all_did(tmp_path, command_line):
    """Texts that are all missing are texts, flags with missing values are flags, and counts are whole numbers."""
    over = ("--over", "network.one_way_delay_packets=1,2", "--over", "coordination.ledger=false", "--seconds", 1, "--seeds", 2)
    for name, stiffness in (("good", "200,300"), ("bad", "20000,30000")):
        varied = ("--over", f"coordination.stiffness_n_per_m={stiffness}", *over)
        command_line("study", "sweep", "--scene", "paper-5.2-wave-16ms", *varied, "--out", tmp_path / name)
        at_most = ("--at-most", "peak_coordination_force_n=40" if name == "good" else "peak_coordination_force_n=0")
        command_line("study", "passive-mean", "wave", *varied, *at_most, "--out", tmp_path / name)
    good, bad = tmp_path / "good", tmp_path / "bad"
    for name, wanted in (("sweep", RUN | MERITS | KEYS), ("study", RUN | MERITS | KEYS), ("study-best", BEST | KEYS), ("study-pairs", PAIRS), ("study-points", POINTS | KEYS)):
        found = types(good / f"{name}.parquet")
        assert found == types(bad / f"{name}.parquet") and wanted.items() <= found.items(), (name, wanted.items() - found.items())
    # What is in them: no reason at all, as texts; some flags that are missing, as flags.
    nothing, all_of_it = (pandas.read_parquet(folder / "sweep.parquet") for folder in (good, bad))
    assert nothing["stable"].all() and nothing["stable"].dtype == bool and nothing["reason"].isna().all()
    assert not all_of_it["stable"].all() and all_of_it[~all_of_it["stable"]]["reason"].str.len().min() > 0
    best = [pyarrow.parquet.read_table(folder / "study-best.parquet").to_pydict() for folder in (good, bad)]
    assert set(best[0]["next_judged"]) == {True} and best[1]["next_judged"] == [None, None] == best[1]["mean"]


def test_the_campaign_and_the_bench_have_types_as_well(tmp_path, command_line):
    command_line("study", "laws", "power", "--out", tmp_path)
    command_line("study", "bench", "--law", "power", "--budget", 2, "--seeds", 1, "--out", tmp_path)
    wanted = {
        "laws": {"law": "string", "packets_per_s": "double"},
        "laws-networks": {"stable": "bool", "verdict": "string", "true_discrepancy_mm": "double", "reason": "string"},
        "all-tunings": {"law": "string", "number": "int64", "felt_n_s_per_m": "double", "reason": "string"},
        "all-runs": {"network": "string", "seed": "int64", "stopped": "bool", "reason": "string", "hand_peak_n": "double"},
        "gains": {"runs": "int64", "stopped": "int64", "reason": "string", "instructions": "int64", "against_network": "string"},
        "fronts": {"declared_mm_per_n": "double", "within_5_mm_per_n": "double", "within_5_stopped": "int64"},
    }
    for name, columns in wanted.items():
        found = types(tmp_path / f"{name}.parquet")
        assert columns.items() <= found.items(), (name, columns.items() - found.items())
        same(tmp_path / f"{name}.csv")
