//! Two-peer ticks a second on one core: scenes alone, side by side in lanes, and the same equations in NumPy, in C, and in MuJoCo.
//!
//! ```text
//! RUSTFLAGS="-C target-cpu=x86-64-v4" cargo bench --package cohold-sim --bench lanes
//! ```
//!
//! `target-cpu` says how wide the vectors are (v4: AVX-512, v3: AVX2; without it SSE2). Times are processor time, the least of several
//! runs. C is compiled here (`CC`, else `cc`), NumPy and MuJoCo are asked for in `PYTHON`, else `python3`; what is not there has no row.
//! The scenes are `matched-line` with sixteen gains. A **tick** is the two peers, devices and network; a **run** is ticks with what
//! `cooperate` measures and the state hash, peers built and figures of merit formed. C and NumPy have the equations alone, without guards,
//! ledger, late packets or a hash ([equations.c](equations.c)); MuJoCo steps a scene of its own of two devices and two copies, without a
//! network.

use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use cohold_columns::Columns;
use cohold_sim::lanes::number::{LANES, lanes_left};
use cohold_sim::lanes::{self, How, Pairs};
use cohold_sim::pair::Pair;
use cohold_sim::run::{Options, Until, run};
use cohold_sim::{Laws, Scene, scenes};

const TICKS: u32 = 20_000;
const HERE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/lanes");

/// What was measured.
struct Measured {
    what: String,
    number: &'static str,
    million_per_s: f64,
}

/// Processor time of this program so far, s.
fn now_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Million ticks a second of `work`, which does that many.
fn rate(ticks: u32, mut work: impl FnMut()) -> f64 {
    let took = (0..9).map(|_| {
        let start = now_s();
        work();
        now_s() - start
    });
    1e-6 * f64::from(ticks) / took.fold(f64::INFINITY, f64::min)
}

fn in_lanes(scenes: &[Scene]) -> [Measured; 4] {
    let measured = |what: &str, million_per_s| Measured { what: what.to_owned(), number: "f64", million_per_s };
    let members: Vec<&Scene> = scenes.iter().collect();
    let seconds = f64::from(TICKS) * 1e-3;
    let all = TICKS * LANES as u32;
    // Built before, as those of C and NumPy are.
    let mut pair = Pair::<f64>::new(&scenes[0]).expect("a built-in scene");
    let alone = rate(TICKS, || (0..TICKS).for_each(|_| pair.step()));
    assert_eq!(pair.fault(), None);
    let mut pairs = Pairs::<1>::new(&members).expect("a built-in scene");
    let side_by_side = rate(all, || (0..TICKS).for_each(|_| pairs.step(&mut |_| ())));
    assert_eq!(lanes_left(), 0);
    [
        measured("ticks, alone", alone),
        measured("ticks, in lanes", side_by_side),
        measured(
            "run, alone",
            rate(TICKS, || {
                let options = Options::unrecorded(seconds);
                black_box(run::<f64>(&scenes[0], options, &|_| {}).expect("a built-in scene").hash);
            }),
        ),
        measured(
            "run, in lanes",
            rate(all, || {
                black_box(lanes::run(How::until(Until::TheEnd), scenes, seconds).expect("a built-in scene").len());
            }),
        ),
    ]
}

/// The first number that a program prints, if it runs.
fn printed(program: &mut Command) -> Option<f64> {
    let output = program.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()?.split_whitespace().next()?.parse().ok()
}

fn in_c(number: &'static str, real: &str, scenes: usize) -> Option<Measured> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("equations");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let compiled = Command::new(compiler)
        .args(["-O3", "-march=native", &format!("-DREAL={real}"), &format!("-DLANES={scenes}"), "-o"])
        .args([&program, &Path::new(HERE).join("equations.c")])
        .arg("-lm")
        .status();
    compiled.ok().filter(|status| status.success())?;
    let what =
        if scenes == 1 { "C, equations alone".to_owned() } else { format!("C, equations alone, {scenes} lanes") };
    Some(Measured { what, number, million_per_s: printed(&mut Command::new(program))? })
}

fn in_python(what: &str, number: &'static str, file: &str, arguments: &[&str]) -> Option<Measured> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let million_per_s = printed(Command::new(python).arg(Path::new(HERE).join(file)).args(arguments))?;
    Some(Measured { what: what.to_owned(), number, million_per_s })
}

fn main() {
    let scenes: Vec<Scene> = (0..LANES)
        .map(|lane| {
            let mut scene = scenes::load(Laws::built_in(), "matched-line").expect("a built-in scene");
            scene.peer.coordination.stiffness_n_per_m *= 0.2 + 0.04 * lane as f64;
            scene
        })
        .collect();
    let mut all: Vec<Measured> = in_lanes(&scenes).into();
    for (number, real, numpy) in [("f32", "float", "float32"), ("f64", "double", "float64")] {
        all.extend([1, LANES].into_iter().filter_map(|scenes| in_c(number, real, scenes)));
        let stacked = ["1000", "2000", "4000", "8000"].into_iter().filter_map(|scenes| {
            in_python(
                &format!("NumPy, equations alone, {scenes} scenes"),
                number,
                "equations.py",
                &[numpy, scenes, "1000"],
            )
        });
        all.extend(stacked.max_by(|one, other| one.million_per_s.total_cmp(&other.million_per_s)));
    }
    all.extend(in_python("MuJoCo", "f64", "scene_mujoco.py", &["100000"]));
    let columns = Columns::of(&all)
        .value("what", |one| one.what.as_str())
        .value("number", |one| one.number)
        .number("million_per_s", 2, |one| one.million_per_s)
        .done();
    print!("{columns}");
}
