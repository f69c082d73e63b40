"""Reads recordings of cohold with the registry's own `mcap`, and compares them with what `cohold recording convert` made of them.

check.py COHOLD records a run in memory and two live peers with this program, and fails with what differs.
"""

import csv
import math
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

UNITS = ("_s", "_m", "_n", "_j", "_m_per_s", "_ppm")
NO_UNIT = {"tick", "mode", "fault", "live", "session", "live_share", "missing", "stable"}
NO_UNIT |= {f"{name}_{peer}" for name in ("mode", "fault") for peer in (1, 2)}


def check(recording: str, table: str) -> None:
    with open(recording, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        facts = {record.name: record.metadata for record in reader.iter_metadata()}
        rows: dict[str, list] = {}
        for schema, channel, message, row in reader.iter_decoded_messages():
            assert schema.encoding == channel.message_encoding == "protobuf", (schema.encoding, channel.message_encoding)
            rows.setdefault(channel.topic, []).append((message, row))
            if channel.topic == "/log":
                assert schema.name == "foxglove.Log", schema.name
    # What happened, in the fields by which Foxglove and Rerun show it.
    log = rows.pop("/log", [])
    start_ns = int(facts["recording"]["start_unix_ns"])
    for message, line in log:
        assert line.DESCRIPTOR.full_name == "foxglove.Log" and line.DESCRIPTOR.enum_types_by_name["Level"].values_by_name["ERROR"].number == 4
        assert line.timestamp.ToNanoseconds() == message.log_time, (line.timestamp, message.log_time)
        assert line.level in (2, 4) and line.message and line.name, line
        assert abs(start_ns + 1e9 * line.time_s - message.log_time) < 1e3, line
    assert log or facts["recording"]["who"] == "both peers", "a live peer has notices"
    assert summary.statistics.message_count - len(log) == sum(map(len, rows.values())) == int(facts["end"]["rows"])
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 0 and facts["end"]["lost"] == "0"
    assert "made" in tomllib.loads(facts["recording"]["scene"]) and facts["recording"]["version"]
    for channel in summary.channels.values():
        names = [field.name for field in rows[channel.topic][0][1].DESCRIPTOR.fields] if channel.topic in rows else []
        for name in names:
            assert name.endswith(UNITS) or name in NO_UNIT, f"{channel.topic}: {name} has no unit"
            assert channel.metadata.get(name), f"{channel.topic}: {name} has no meaning"
    first = min(summary.channels.values(), key=lambda channel: channel.id).topic
    with open(table, newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(rows[first]) > 500, (len(lines), len(rows[first]))
    last_ns = 0
    for line, (message, row) in zip(lines, rows[first]):
        assert int(float(line.pop("row"))) == message.sequence
        assert message.log_time >= last_ns
        last_ns = message.log_time
        assert list(line) == [field.name for field in row.DESCRIPTOR.fields]
        for name, text in line.items():
            told, read = float(text), getattr(row, name)
            assert told == read or math.isnan(told) and math.isnan(read), (name, told, read)
    print(f"{recording}: {len(rows)} channels, {len(lines)} rows of {first} are those of {table}")


SCENE = ["--scene", "any-network", "--set=user.1.push_n=1", "--set=user.2.push_n=1", "--seconds=2", "--json"]
ADDRESSES = ["127.0.0.1:47101", "127.0.0.1:47102"]


def main(program: str) -> None:
    with tempfile.TemporaryDirectory() as made:

        def begin(*words: str) -> subprocess.Popen:
            return subprocess.Popen([program, *words], cwd=made)

        def done(*running: subprocess.Popen) -> None:
            ended = [one.wait() for one in running]
            assert not any(ended), (running[0].args, ended)

        def peer(number: int) -> subprocess.Popen:
            listen, connect = ADDRESSES[number - 1], ADDRESSES[2 - number]
            ends = ["--number", str(number), "--listen", listen, "--connect", connect, "--key-file", "key"]
            return begin("peer", "--quiet", *ends, *SCENE, "--record", f"peer-{number}.mcap")

        done(begin("cooperate", *SCENE, "--record", "memory.mcap"))
        done(begin("key", "generate", "--json", "key"))
        done(peer(1), peer(2))
        for name in ["memory", "peer-1", "peer-2"]:
            done(begin("recording", "convert", "--json", f"{name}.mcap", f"{name}.csv"))
            check(str(Path(made) / f"{name}.mcap"), str(Path(made) / f"{name}.csv"))


main(sys.argv[1])
