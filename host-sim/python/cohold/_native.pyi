import os
import pathlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal, Protocol, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Scalar = Literal["f32", "f64", "i32f32"]
_Value = bool | int | float | str
_Path = str | os.PathLike[str]
_Runs = list[tuple[int, list[int]]]
_Progress = Callable[[int, int], object]
# A float along one axis; along several a tuple of as many.
_Along = Any
_Forces = Sequence[float] | NDArray[np.float64]

__all__ = [
    "Findings",
    "Journal",
    "LivePeer",
    "LiveState",
    "Pair",
    "Pairs",
    "Peer",
    "Run",
    "Scene",
    "Stability",
    "Study",
    "Sweep",
    "__version__",
    "add_law",
    "advice",
    "generate_key",
    "keys",
    "limit",
    "run",
    "scenes",
    "stability",
    "unit",
]

__version__: str

@final
class Scene:
    """What two peers, their users, their devices and the network between them are told before a run.

    Without a source it is the cooperation paper's section 5. A `str` is the name of a built-in scene (`scenes()`) or a file, a
    `pathlib.Path` a file. Settings are then applied in their order. Keys, units and ranges are those of scene files (`keys()`).

    Raises ValueError with the line that the command line prints, and OSError for a file that cannot be read.
    """

    def __new__(cls, source: Scene | _Path | None = None, settings: Mapping[str, _Value] | None = None) -> Scene: ...
    @staticmethod
    def from_toml(text: str) -> Scene:
        """The scene that this TOML text says, as a scene file holds it."""

    def to_toml(self) -> str:
        """What differs from the default scene, as the text of a scene file. Traces are named by their whole path."""

    def __getitem__(self, key: str, /) -> bool | float | str: ...
    def get(self, key: str, default: Any = None, /) -> Any:
        """The value of a key, or `default` if there is none."""

    def keys(self) -> list[str]:
        """Every key of this scene, its law's keys included: `dict(scene)` has all settings."""

    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __contains__(self, key: object, /) -> bool: ...
    def __setitem__(self, key: str, value: _Value, /) -> None: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, memo: object) -> Scene: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Run:
    """What a run gave, as `cohold cooperate` tells it."""

    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """Every recorded column by name (the unit is its end), a row a recorded tick: what stands in the command's CSV."""

    @property
    def axes(self) -> list[dict[str, NDArray[Any]]]:
        """The columns of each shared axis, the first one first; `columns` are those of the first."""

    @property
    def merits(self) -> dict[str, float | None]:
        """Figures of merit by name; None where there is none, as of a run that failed."""

    @property
    def stable(self) -> bool:
        """Nothing failed."""

    @property
    def verdict(self) -> Literal["stable", "apart", "NO"]:
        """`stable`, `apart` or `NO`."""

    @property
    def reason(self) -> str | None:
        """Why it is not stable."""

    @property
    def fault(self) -> tuple[int, str] | None:
        """The peer (1 or 2) that stopped first, and its fault."""

    @property
    def fault_time_s(self) -> float | None:
        """When, s."""

    @property
    def spectral_radius(self) -> float:
        """Largest absolute eigenvalue of the scene over a packet period, both hands on."""

    @property
    def unstable_modes(self) -> list[str]:
        """The modes of the scene that are not stable, whatever the run showed: whose hands are on (both, one, none)."""

    @property
    def ticks(self) -> int:
        """Ticks done."""

    @property
    def state_hash(self) -> str:
        """Hash of both peers' states over every tick, the same bits wherever it is computed."""

@final
class Stability:
    """The verdict on a scene in every mode that it can enter."""

    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @property
    def stable(self) -> bool:
        """Every mode is stable."""

    @property
    def spectral_radius(self) -> float:
        """The largest absolute eigenvalue over a packet period, of the worst mode."""

    @property
    def modes(self) -> dict[str, float]:
        """The spectral radius by who has hands on: both, one, none."""

    @property
    def not_judged(self) -> list[str]:
        """What the scene has and the verdict leaves out, in words."""

@final
class Pair:
    """Two peers in a scene, stepped by the tick; what the scene's users do, they do as well.

    Forces are N toward the other peer, from -1000 to 1000: of each user a number, or, along several shared axes, as many (user 2's point
    the opposite way along every axis). What a step gives is the 12 numbers that `COLUMNS` names, after the tick; along several axes a row
    of them for each. One thread at a time may step it.
    """

    COLUMNS: list[str]
    def __new__(cls, scene: Scene | _Path, scalar: _Scalar = "f64") -> Pair: ...
    @overload
    def step(self, force_1_n: float, force_2_n: float) -> tuple[float, ...]:
        """One tick: 12 numbers as a tuple; along several axes a tuple of one for each."""

    @overload
    def step(self, force_1_n: _Forces, force_2_n: _Forces) -> tuple[tuple[float, ...], ...]:
        """One tick: 12 numbers as a tuple; along several axes a tuple of one for each."""

    def step_into(self, force_1_n: float | _Forces, force_2_n: float | _Forces, out: NDArray[np.float64]) -> None:
        """One tick into an array of 12 float64 that the caller keeps, or of 12 for each of several axes: nothing is allocated."""

    def steps(self, forces_n: ArrayLike) -> NDArray[np.float64]:
        """As many ticks as `forces_n` has rows of two (user 1, user 2), 20,000,000 at the most: a row of 12 for each. Along several axes
        both have one dimension more: forces are (ticks, 2, axes), and what is given (ticks, axes, 12).
        """

    def state_hash(self, before: int = ...) -> int:
        """Hash of both peers' states, continued from the one before; after every tick of a run it is the run's `state_hash`."""

    @property
    def ticks(self) -> int:
        """Ticks done so far."""

    @property
    def time_s(self) -> float:
        """Time of the next tick, s."""

    @property
    def fault(self) -> tuple[int, str] | None:
        """Which peer (1 or 2) stopped, and why."""

@final
class Pairs:
    """Many pairs of one scene, stepped together in one call, on so many threads: each is a `Pair` with a seed of its own, to the last bit, and
    begins anew when it is told to.

    What is seen of a pair is the 22 numbers that `COLUMNS` names; along several axes a row of them for each. One thread at a time may step them.
    """

    COLUMNS: list[str]
    def __new__(cls, scene: Scene | _Path, count: int, scalar: _Scalar = "f64", threads: int = 1) -> Pairs: ...
    def __len__(self) -> int: ...
    def begin(self, pairs: Sequence[int] | NDArray[np.integer[Any]], seeds: Sequence[int] | NDArray[np.integer[Any]]) -> None:
        """Has these pairs (numbers from 0) begin anew, armed and at rest, each with its `network.seed`."""

    def steps(self, forces_n: ArrayLike, ticks: int = 1) -> NDArray[np.float64]:
        """So many ticks of all pairs, 1,000,000 at the most, each with its row of `forces_n` held: (pairs, 2), user 1 and user 2, along several
        axes (pairs, 2, axes). Gives what is seen after the last one: (pairs, 22), along several axes (pairs, axes, 22).
        """

    def seen(self) -> NDArray[np.float64]:
        """What is seen now, as `steps` gives it."""

    @property
    def engaged(self) -> NDArray[np.bool_]:
        """Which copies are coupled, (pairs, 2): not once a peer has stopped, nor while it hears nothing of the other one."""

    @property
    def faults(self) -> list[tuple[int, str] | None]:
        """Of each pair which peer (1 or 2) stopped, and why."""

    def state_hashes(self) -> list[int]:
        """Of each pair what `Pair.state_hash` gives."""

@final
class Peer:
    """One peer of a scene, armed, for a program that has device, hand and network of its own: another simulator, or a trial of one's own.

    Places and forces are of the shared world, in which x points from peer 1 to peer 2; along several shared axes each is a sequence. The
    scene's device, users and network are not simulated; its verdict (`stability`) is about them all the same. A peer is a value:
    `copy.copy(peer)` is a saved state that goes on by itself.
    """

    PACKET: list[str]
    def __new__(cls, scene: Scene | _Path, number: int, scalar: _Scalar = "f32") -> Peer: ...
    @overload
    def tick(
        self, position_m: float, velocity_m_per_s: float, packet: tuple[float, ...] | None = None
    ) -> tuple[float, tuple[float, ...] | None]:
        """A control period: the hand's place (m) and speed (m/s), and the newest packet that came of the other peer since the period before,
        or None. Gives the force on the device (N), and the packet to send to the other peer, or None between two of them.
        """

    @overload
    def tick(
        self, position_m: _Forces, velocity_m_per_s: _Forces, packet: tuple[tuple[float, ...], ...] | None = None
    ) -> tuple[tuple[float, ...], tuple[tuple[float, ...], ...] | None]:
        """A control period: the hand's place (m) and speed (m/s), and the newest packet that came of the other peer since the period before,
        or None. Gives the force on the device (N), and the packet to send to the other peer, or None between two of them.
        """

    def reset(self) -> None:
        """Goes back to where it was when it was made: armed, at rest, before its first tick."""

    def state_hash(self, before: int = ...) -> int:
        """Hash of the state, continued from the one before."""

    def __copy__(self) -> Peer: ...
    def __deepcopy__(self, _memo: object) -> Peer: ...
    @property
    def start_m(self) -> _Along:
        """Where the hand has to be at first, m: just clear of the object."""

    @property
    def object_m(self) -> _Along:
        """Where this peer's copy of the object is, m."""

    @property
    def ticks(self) -> int:
        """Control periods done so far."""

    @property
    def engaged(self) -> bool:
        """Whether its copy is coupled to the other one: not once it has stopped, nor while it hears nothing of the other peer."""

    @property
    def fault(self) -> str | None:
        """Why it stopped; its forces are 0 from then on."""

@final
class Sweep:
    """A scene over its keys and over seeds, the question that `cohold study sweep` asks.

    `over` is a grid: for each key its values, as a sequence or as the command line writes them ("200..20000:20:log", "0,0.1,0.3").
    `sample` is drawn, `points` of it at each point of the grid, evenly by `design` ("sobol" or "latin-hypercube"): for each key a range
    ("0..0.3", "0.02..1:log", "1..9:whole") or values. Every point is run for `seconds` in f64 with the same `seeds`.

    Raises ValueError for a key that there is not, and for a value or a combination that is not allowed at any point.
    """

    def __new__(
        cls,
        scene: Scene | _Path,
        over: Mapping[str, str | Sequence[_Value]] | list[str] | None = None,
        sample: Mapping[str, str | Sequence[_Value]] | list[str] | None = None,
        points: int | None = None,
        design: Literal["sobol", "latin-hypercube"] = "sobol",
        sample_seed: int = 1,
        seeds: int = 1,
        seconds: float = 20.0,
    ) -> Sweep: ...
    @property
    def points(self) -> int:
        """How many points there are."""

    @property
    def runs(self) -> int:
        """How many runs: points times seeds."""

    @property
    def seconds(self) -> float:
        """Simulated time of a run, s."""

    @property
    def keys(self) -> list[str]:
        """The keys that are varied."""

    @property
    def made(self) -> list[str]:
        """Version, commit, and the sums of traces: what must be alike wherever the sweep is run."""

    def scene_at(self, point: int) -> Scene:
        """The scene of a point, with the first seed."""

    def run(
        self, folder: _Path | None = None, threads: int = 0, progress: _Progress | None = None
    ) -> dict[str, NDArray[Any]]:
        """Runs everything on so many threads (0: as many as there are cores) and gives the table by column, a row a run.

        With a folder it is kept there as `cohold study sweep --out` keeps it: what is there already is not run again, and in the end
        `sweep.csv` and `sweep.parquet` stand there. Raises OSError where that is another sweep's folder, or cannot be written.
        `progress` is told now and then how many runs are done, and of how many.
        """

    def open(self, folder: _Path) -> Journal:
        """Goes on with the sweep in this folder, or begins it there; for who hands its runs to others."""

    def rows(self, runs: _Runs, threads: int = 1) -> bytes:
        """Does these runs, each a point with its seeds, and gives their rows as lines for `Journal.append`."""

    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Study:
    """Scenes or laws over keys, networks and seeds: which is best where, under which bounds, and how sure that is; the question of `cohold
    study`.

    `entrants` are texts as the command line takes them ("wave", "any-network,object.mass_kg=0.1", a law at its own gains or a scene), or
    a dict from names to scenes. `networks` are names ("own", as each scene has it; "all"), or paths of recordings. Axes and sample are those
    of `Sweep`, and may be left out. Every point is run for `seconds` in f64 with the same `seeds`: the first half chooses the best point,
    the other half says how good it is.

    Raises ValueError for what there is not, and for a value or a combination that is not allowed at any point.
    """

    def __new__(
        cls,
        entrants: str | Sequence[str] | Mapping[str, Scene | _Path],
        over: Mapping[str, str | Sequence[_Value]] | list[str] | None = None,
        networks: _Path | Sequence[_Path] | None = None,
        sample: Mapping[str, str | Sequence[_Value]] | list[str] | None = None,
        points: int | None = None,
        design: Literal["sobol", "latin-hypercube"] = "sobol",
        sample_seed: int = 1,
        seeds: int = 20,
        seconds: float = 20.0,
    ) -> Study: ...
    @property
    def points(self) -> int:
        """How many points there are: entrants times networks times points of the grid."""

    @property
    def runs(self) -> int:
        """How many runs: points times seeds."""

    @staticmethod
    def network_names() -> list[str]:
        """The names that `networks` takes beside "all"."""

    def run(
        self,
        folder: _Path | None = None,
        threads: int = 0,
        progress: _Progress | None = None,
        search: Literal["grid", "halving"] = "grid",
        best: str = "true_discrepancy_mm",
        at_most: Mapping[str, float] | None = None,
    ) -> Findings:
        """Runs everything on so many threads (0: as many as there are cores); or with `search="halving"` only what decides which points have the least
        of `best` under the bounds `at_most`, which is then what may be asked of the findings.

        With a folder it is kept there as `cohold study --out` keeps it: what is there already is not run again, and in the end
        `study.csv` and `study.parquet` stand there. Raises OSError where that is another study's folder, or cannot be written.
        `progress` is told now and then how many runs are done, and of how many; a search may need fewer.
        """

@final
class Findings:
    """What a study found."""

    @property
    def rows(self) -> dict[str, NDArray[Any]]:
        """Every run by column, a row a run, with every mode's verdict."""

    @property
    def points(self) -> dict[str, NDArray[Any]]:
        """Every point by column: means over all its seeds, with half of their 95 % intervals; 0 runs where a search left it out."""

    def best(
        self, best: str = "true_discrepancy_mm", at_most: Mapping[str, float] | None = None
    ) -> dict[str, NDArray[Any]]:
        """Of each entrant on each network the point with the least of a figure of merit, among those that are stable in every run and every
        mode and of which no run is beyond a bound (`at_most`: figures of merit and numbers); what seeds say of it that did not choose it.
        """

    def pairs(
        self, best: str = "true_discrepancy_mm", at_most: Mapping[str, float] | None = None
    ) -> dict[str, NDArray[Any]]:
        """The best points of every two entrants beside each other, seed by seed, on networks where both have one."""

    def draw(
        self,
        folder: _Path,
        name: str = "study-best",
        best: str = "true_discrepancy_mm",
        at_most: Mapping[str, float] | None = None,
        width_mm: float = 88.0,
    ) -> list[pathlib.Path]:
        """Writes the figure as `name` with .svg, .pdf and .png into a folder, `width_mm` wide (88 is a column of most journals, 180 a page);
        gives the paths. Nothing is overwritten.
        """

@final
class Journal:
    """A folder of a sweep that is being filled; nobody else fills it until `close`, or the end of its `with`."""

    def missing(self) -> _Runs:
        """The runs that are not there yet: points, each with its seeds."""

    def append(self, lines: bytes) -> None:
        """Adds rows as `Sweep.rows` gives them."""

    def finish(self) -> dict[str, NDArray[Any]]:
        """The table by column, when every run is there; writes `sweep.csv` and `sweep.parquet`, and closes the journal."""

    def close(self) -> None:
        """Lets others fill the folder."""

    def __enter__(self) -> Journal: ...
    def __exit__(self, *_error: object) -> None: ...

_Numbers = Sequence[float] | NDArray[Any]

class _Device(Protocol):
    """A slow device in Python: asked 200 times a second at most, in a thread of its own (docs/guides/python.md).

    `read` gives where the hand is along each axis (m), or that and how fast it moves (m/s). Beside it may be `axes` (1 without it), `name`,
    `max_force_n`, `workspace_m` (of each axis), and `is_homed`; without `lets_go_s`, how long it holds a force after the last `write`, or
    without being homed, it is not armed.
    """

    def read(self) -> Iterable[float] | tuple[Iterable[float], Iterable[float]]: ...
    def write(self, force_n: tuple[float, ...], /) -> object: ...


@final
class LiveState:
    """What a live peer was at its newest tick. Along several shared axes each quantity is a tuple; places and forces are of the shared world."""

    @property
    def time_s(self) -> float:
        """Time since the peer began, s."""

    @property
    def tick(self) -> int:
        """Control periods in which its hand moved."""

    @property
    def mode(self) -> Literal["calling", "waiting", "held", "refused", "alone", "armed", "faulted"]:
        """calling, waiting (for the other end, a verdict or arming), refused, alone, armed, faulted; held while it is not wanted armed. The
        motors are on in alone (both ends have not been live yet) and in armed."""

    @property
    def fault(self) -> str | None:
        """What stopped it."""

    @property
    def hand_m(self) -> _Along:
        """Where the hand is, m."""

    @property
    def hand_m_per_s(self) -> _Along:
        """How fast it moves, m/s."""

    @property
    def object_m(self) -> _Along:
        """Where this peer's copy of the object is, m."""

    @property
    def object_m_per_s(self) -> _Along:
        """How fast it moves, m/s."""

    @property
    def peer_m(self) -> _Along:
        """Where the other peer's copy is, as far as this one knows: what the coordination acts upon, m."""

    @property
    def peer_m_per_s(self) -> _Along:
        """How fast that moves, m/s."""

    @property
    def force_n(self) -> _Along:
        """Force at the hand, as the peer commands it, N; 0 while its motors are off."""

    @property
    def contact_force_n(self) -> _Along:
        """Force of contact on the copy, N."""

    @property
    def coordination_force_n(self) -> _Along:
        """Force of coordination on the copy, N."""

@final
class LivePeer:
    """A peer in real time: `cohold peer` in a native thread of its own, with no Python in its tick, read and steered from here at any rate.

    `scene` is a Scene, the name of a built-in one, a file, or a dict of settings over the recommended scene; `number` 1 (left) or 2
    (right); `listen` and `connect` are where this end and the other one are, `key` is the key file that both have (`generate_key`).
    `device` is what `--device` takes, or an object with `read` and `write` (docs/guides/python.md); what else is told of it has the names of the
    command's flags, as device_axes. Without `seconds` it goes on until it is stopped, and the means of its report are of the whole run.
    With `arm=False` it waits for `arm()`. The user of a built-in scene does not push, unless `settings` has a push. What ends the
    object lets go.

    Raises ValueError for what is not allowed, and OSError for a file or an address that cannot be opened.
    """

    def __new__(
        cls,
        scene: Scene | _Path | Mapping[str, _Value],
        number: int,
        *,
        listen: str,
        connect: str,
        key: _Path,
        device: str | _Device | None = None,
        settings: Mapping[str, _Value] | None = None,
        seconds: float | None = None,
        patience_s: float = 30.0,
        anyway: bool = False,
        arm: bool = True,
        record: _Path | None = None,
        **device_settings: bool | float | str | Sequence[float] | Sequence[str],
    ) -> LivePeer: ...
    @property
    def state(self) -> LiveState:
        """What it was at its newest tick."""

    @property
    def second(self) -> dict[str, Any] | None:
        """What its newest whole second was, and what was measured of the line in it: as `cohold peer --json-lines` says it; None before."""

    @property
    def verdict(self) -> dict[str, Any] | None:
        """What its scene is at the delays that were measured: stable, spectral_radius, one_way_ms, text, instead, not_judged; None before."""

    @property
    def running(self) -> bool:
        """Whether it has not ended."""

    @property
    def report(self) -> dict[str, Any] | None:
        """What `cohold peer --json` reports at the end; None while it runs. Raises RuntimeError if the run failed."""

    @property
    def clutch(self) -> bool:
        """Whether the clutch is held open from here; the device's own button opens it, too."""

    @clutch.setter
    def clutch(self, value: bool, /) -> None: ...
    def arm(self) -> None:
        """Arms it as soon as it may: the other end is there, and the verdict lets it. After a fault this forgets the fault."""

    def disarm(self) -> None:
        """Turns its motors off, from the next tick on; the line stays, and `arm()` goes on."""

    def push(self, force_n: float | _Forces) -> None:
        """Has the hand at a simulated device push with this force beside what the scene's user does, N toward positive x, until told otherwise."""

    def move_hand(self, position_m: float | _Forces | None, /) -> None:
        """Has a hand at a simulated device go there, m of the device's own (of the shared world, where `scale.position` is 1), or let go with None: from
        where the device is, at most 0.5 m/s fast, by a spring of 200 N/m and a damper of 12 N·s/m that pull with at most 10 N. Places that are told
        60 times a second make a smooth motion.
        """

    def wait_armed(self, timeout_s: float | None = None) -> bool:
        """Waits until it is armed and both ends are live; False if the time is over first. Raises RuntimeError if the run failed meanwhile."""

    def wait(self, timeout_s: float | None = None) -> bool:
        """Waits until it has ended; False if the time is over first. Raises RuntimeError if the run failed."""

    def stop(self) -> dict[str, Any] | None:
        """Lets go, tells the other end, and gives the report. Raises RuntimeError if the run failed."""

    def close(self) -> None:
        """Lets go and tells the other end, whatever came of the run."""

    def __enter__(self) -> LivePeer: ...
    def __exit__(self, kind: object, error: object, traceback: object, /) -> None: ...

def generate_key(file: _Path) -> None:
    """Makes a new key file for two peers; an existing file is left alone. Copy it to the other end over a way that you trust."""

class _Law(Protocol):
    """A coordination law in Python: what it is told are tuples of floats, and what it answers are numbers (docs/guides/python.md)."""

    @property
    def name(self) -> str: ...
    @property
    def sends(self) -> str: ...
    @property
    def keys(self) -> Mapping[str, tuple[float, float, float, str, str]]: ...
    @property
    def reads(self) -> Sequence[str]: ...
    @property
    def gains(self) -> Sequence[str]: ...
    def start(self, values: tuple[float, ...], local: tuple[float, float], /) -> _Numbers: ...
    def receive(self, values: tuple[float, ...], state: tuple[float, ...], packet: tuple[float, ...], /) -> _Numbers: ...
    def couple(
        self,
        values: tuple[float, ...],
        state: tuple[float, ...],
        local: tuple[float, float],
        contact_force_n: float,
        age_ticks: int,
        /,
    ) -> Sequence[Any]: ...
    def send(self, values: tuple[float, ...], state: tuple[float, ...], local: tuple[float, float], /) -> _Numbers: ...

def add_law(law: _Law) -> None:
    """Makes a law that is written in Python known: every scene can name it from then on, for the life of the process.

    One of the same name takes the place of that law, if what it declares is the same.
    """

def advice(scene: Scene | _Path) -> str:
    """What to change in a scene that is unstable, in one sentence."""

def keys() -> dict[str, dict[str, Any]]:
    """Every key of a scene: its default, what it accepts, its unit and its meaning."""

def limit(scene: Scene | _Path, key: str, first: float, last: float) -> list[float]:
    """The values of a key between two ends at which the scene becomes stable or unstable, every mode considered."""

def run(
    scene: Scene | _Path,
    seconds: float = 20.0,
    scalar: _Scalar = "f64",
    every: int | None = None,
    progress: _Progress | None = None,
) -> Run:
    """Runs a scene for so many simulated seconds.

    `scalar` is the number type of the peers: f32 as the board, f64, or i32f32 (fixed point). Every `every`-th tick is recorded, 0 for
    none; without it at most about 100,000 rows are, as the command line has it. `progress` is told now and then how many ticks are done, and of
    how many. Other Python threads go on meanwhile.
    """

def scenes() -> list[str]:
    """The names of the built-in scenes."""

def stability(scene: Scene | _Path) -> Stability:
    """Is this scene stable, and by how much? Of the linear scene behind it: both hands on, one, none."""

def unit(name: str) -> str:
    """The unit of a column or a figure of merit, by the end of its name; empty of what has none: a count, a ratio, a flag, words."""
