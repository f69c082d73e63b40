//! Any moment of the past, in the picture, in the numbers and in the plots at once; while it runs, and in recordings.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks;

use super::{Browser, Play, Window, click, folder, middle, set};
use crate::program::cohold;

/// How far the copies are apart at the moment that is shown, mm: as the page writes it, as it draws it, and in the CSV that it exports.
fn apart(browser: &mut Browser, window: &Window) -> [f64; 3] {
    browser.numbers(
        window,
        "(() => { const [head, ...rows] = page.asCsv().trim().split('\\n').map((row) => row.split(',')); \
         const row = rows.find((row) => row[0] === page.time()); \
         const at = (name) => Number(row[head.indexOf(name)]); \
         return [Number(document.getElementById('true').textContent), parseFloat(document.querySelector('#pair .gap').textContent), \
         1e3 * Math.abs(at('object_1_m') - at('object_2_m'))]; })()",
    )
}

/// Until the numbers are those of the moment that is shown; written, drawn and exported they are the same.
#[track_caller]
fn agrees(browser: &mut Browser, window: &Window) -> f64 {
    let mut seen = [f64::NAN; 3];
    for _ in 0..100 {
        seen = apart(browser, window);
        let [written, drawn, exported] = seen;
        if (written - exported).abs() <= 6e-4 && (drawn - exported).abs() <= 6e-3 {
            return exported;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("written, drawn, exported: {seen:?}");
}

#[test]
fn the_past_is_shown_stepped_and_slowed() {
    let play = Play::start(&["--partner", "carries-on", "--scene", "paper-5.2-passive-wave-16ms"]);
    let mut browser = Browser::start(folder().join("timeline"));
    let one = browser.open(&play.person(1));
    browser.wait(&one, "Math.abs(page.value('object_1') - page.value('object_1', 1000)) > 0.003 && Number.isFinite(page.value('device_1', 3500))");
    browser.wait(&one, "!document.body.classList.contains('past') && document.getElementById('past').hidden");

    // By keys: a pause, then a second and a half back. Everything shows that moment, and it is said that it is past.
    browser.evaluate(&one, "document.getElementById('scrub').focus()");
    browser.key(&one, " ");
    let [end] = browser.numbers(&one, "[page.moment()]");
    browser.key(&one, "PageDown");
    for _ in 0..3 {
        browser.key(&one, "ArrowLeft");
    }
    browser.wait(&one, &format!("page.moment() === {end} - 1003"));
    browser.wait(&one, "document.body.classList.contains('past') && !document.getElementById('past').hidden");
    browser.wait(&one, "Number(document.getElementById('moment').textContent.replace(' s ago', '')) >= 1");
    browser.wait(&one, "document.getElementById('scrub').getAttribute('aria-valuetext').endsWith(' s ago')");
    agrees(&mut browser, &one);
    let line = browser.evaluate(&one, "document.getElementById('cursor').textContent");
    let time = browser.evaluate(&one, "page.time()");
    assert!(line.as_str().is_some_and(|line| line.starts_with(time.as_str().expect("a time"))), "{line} {time}");
    browser.picture(&one, &folder().join("past.png"));

    // A tick and a packet period, on and back; the picture follows.
    for (button, ticks) in [("tick-on", 1), ("packet-on", 8), ("packet-back", -8), ("tick-back", -1)] {
        let [before] = browser.numbers(&one, "[page.moment()]");
        click(&mut browser, &one, button);
        browser.wait(&one, &format!("page.moment() === {before} + {ticks}"));
        agrees(&mut browser, &one);
    }

    // Played at a tenth of its speed it goes a tenth as far; however slow the machine is, never further.
    set(&mut browser, &one, "speed", "0.1");
    browser.key(&one, " ");
    browser.wait(&one, "document.getElementById('pause').textContent === 'Pause'");
    let look = "[performance.now(), page.moment()]";
    let [from_ms, from] = browser.numbers(&one, look);
    browser.wait(&one, &format!("page.moment() > {from} + 100"));
    let [to_ms, to] = browser.numbers(&one, look);
    assert!((to - from) / (to_ms - from_ms) < 0.13, "{from} to {to} in {} ms", to_ms - from_ms);

    // What is done acts now: Stop stops while the past plays on.
    click(&mut browser, &one, "stop");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('stopped: motors are off')");
    browser.wait(&one, "document.body.classList.contains('past')");
    click(&mut browser, &one, "start");
    browser.wait(&one, "!document.getElementById('status').textContent.startsWith('stopped')");

    // One control comes back; taking the hand does, too.
    click(&mut browser, &one, "now");
    browser.wait(
        &one,
        "!document.body.classList.contains('past') && document.getElementById('moment').textContent === 'now'",
    );
    let [now] = browser.numbers(&one, "[page.moment()]");
    assert!(now > end);
    browser.wait(&one, &format!("page.moment() > {now}"));
    browser.evaluate(&one, "page.replay(2, 0.1)");
    browser.wait(&one, "document.body.classList.contains('past') && document.getElementById('speed').value === '0.1'");
    let [ago] = browser.numbers(&one, "[Number(document.getElementById('moment').textContent.replace(' s ago', ''))]");
    assert!((1.9..10.0).contains(&ago), "{ago}");
    // At full speed it comes to where it was asked for, and holds that.
    browser.evaluate(&one, "page.replay(2, 1)");
    let [asked] = browser.numbers(&one, "[page.moment()]");
    browser.wait(&one, "document.getElementById('pause').textContent === 'Play'");
    let [held] = browser.numbers(&one, "[page.moment()]");
    assert!(held > asked && held - asked <= 2000.0, "{asked} {held}");
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    browser.wait(&one, "!document.body.classList.contains('past')");
    browser.mouse(&one, "mouseReleased", hand);

    // A press on a plot goes there.
    browser.evaluate(&one, "document.getElementById('apart').scrollIntoView()");
    browser.wait(&one, "document.getElementById('apart').width > 100");
    let plot = middle(&mut browser, &one, "apart");
    browser.mouse(&one, "mousePressed", plot);
    browser.mouse(&one, "mouseReleased", plot);
    browser.wait(&one, "document.body.classList.contains('past')");
    agrees(&mut browser, &one);
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// At rest nothing of the page is drawn, nor written into it: not while it runs, and not while the past is looked at.
#[test]
fn at_rest_nothing_is_drawn() {
    let play = Play::start(&["--partner", "follows"]);
    let mut browser = Browser::start(folder().join("rest"));
    let one = browser.open(&play.addresses[0]);
    browser.wait(&one, "Number.isFinite(page.value('device_1', 4500))");
    browser.evaluate(
        &one,
        "window.changes = []; for (const name of ['fillRect', 'clearRect']) { const of = CanvasRenderingContext2D.prototype; \
         const was = of[name]; of[name] = function (...all) { changes.push(name); return was.apply(this, all); }; } \
         new MutationObserver((all) => changes.push(...all.filter(({ target }) => !document.getElementById('late').contains(target)) \
         .map(({ target, attributeName }) => `${(target.closest ? target : target.parentNode)?.closest('[id]')?.id} ${attributeName}`))) \
         .observe(document.body, { subtree: true, childList: true, attributes: true, characterData: true });",
    );
    let ten = |browser: &mut Browser| {
        browser.evaluate(&one, "changes.length = 0");
        let [frames] = browser.numbers(&one, "[page.frames()]");
        browser.wait(&one, &format!("page.frames() > {frames} + 10"));
        browser.evaluate(&one, "changes.join('; ')")
    };
    // What was there at the beginning may still be on its way.
    assert!((0..20).any(|_| ten(&mut browser) == ""), "{}", ten(&mut browser));
    // A hand that moves is drawn, and what comes after it is rest again.
    browser.evaluate(&one, "document.getElementById('hand').focus()");
    browser.key(&one, "ArrowRight");
    browser.wait(&one, "changes.some((change) => change.startsWith('pair '))");
    browser.key(&one, "Escape");
    browser.evaluate(&one, "document.getElementById('hand').blur()");
    assert!((0..30).any(|_| ten(&mut browser) == ""), "{}", ten(&mut browser));
}

/// Processor time of a browser whose page is at rest, all its processes together, at the median of five times eight seconds: a table for docs/project/notes/live-measurements.md.
#[test]
#[ignore = "takes minutes, and tells of the machine"]
fn how_much_rest_costs() {
    println!("| page | share of a core, % |");
    println!("|---|---|");
    for (what, before) in [("at rest", ""), ("paused", "document.getElementById('pause').click()")] {
        let play = Play::start(&["--partner", "follows"]);
        let mut browser = Browser::start(folder().join("rest-costs"));
        let one = browser.open(&play.addresses[0]);
        browser.wait(&one, "Number.isFinite(page.value('device_1', 6000))");
        browser.evaluate(&one, before);
        // A browser has things of its own to do when it has just been started.
        std::thread::sleep(Duration::from_secs(30));
        let mut shares: Vec<f64> = Vec::new();
        for _ in 0..5 {
            let (begun, before_s) = (Instant::now(), browser.processor_s());
            std::thread::sleep(Duration::from_secs(8));
            shares.push((browser.processor_s() - before_s) / begun.elapsed().as_secs_f64());
        }
        shares.sort_by(f64::total_cmp);
        let share = shares[shares.len() / 2];
        println!("| {what} | {:.1} |", 100.0 * share);
    }
}

fn fresh(name: &str) -> PathBuf {
    let folder = folder().join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

/// Clock of peer 2, when that of peer 1 shows this.
fn other(at_s: f64) -> f64 {
    at_s + 3.25
}

/// Where a copy is, and how fast: they are apart by up to 8 mm.
fn course(end: usize, at_s: f64) -> (f64, f64) {
    let (reach, rate) = ([0.020, 0.012][end], 1.5);
    (reach * (rate * at_s).sin(), reach * rate * (rate * at_s).cos())
}

/// Records a peer whose copy goes its course for twenty seconds.
fn peer(end: usize, file: &Path) {
    let who = format!("peer {}", end + 1);
    let origin = Origin {
        version: "0".into(),
        provenance: "[coordination]\ncomm = \"self-timed\"\n".into(),
        who,
        start_unix_ns: 1_700_000_000_000_000_000,
        clock: format!("of {}", end + 1),
        start_clock_ns: 0,
    };
    let recorder = Recorder::create(file, &origin, ticks::channels(&format!("peer_{}", end + 1), 1)).expect("a file");
    let late_s = [0.0, 0.4e-3][end];
    let own = |at_s: f64| if end == 0 { at_s } else { other(at_s) };
    for at in 0..20_000_u32 {
        let at_s = 1.0 + 1e-3 * f64::from(at) + late_s;
        let (place, speed) = course(end, at_s);
        let of = |name: &str| match name {
            "time_s" => own(at_s),
            "tick" => f64::from(at),
            "mode" | "live" => 1.0,
            "object_m" | "device_m" => place,
            "object_m_per_s" => speed,
            _ => 0.0,
        };
        let row: Vec<f64> = ticks::TICK.iter().map(|(name, _)| of(name)).collect();
        let time_ns = (1e9 * own(at_s)) as u64;
        recorder.put_all(0, time_ns, &row);
        if at % 64 == 0 {
            let there = |at_s: f64| if end == 0 { other(at_s) } else { at_s };
            let times = [own(at_s), there(at_s + 150e-6), there(at_s + 650e-6), own(at_s + 800e-6), 7.0];
            recorder.put_all(1, time_ns, &times);
        }
    }
    assert_eq!((recorder.finish().lost, 0), (0, 0));
}

/// Goes to a time of a recording, and gives how long it took until numbers and picture were there, ms, and how far the copies were apart, mm.
fn jump(browser: &mut Browser, window: &Window, second: f64) -> [f64; 2] {
    let jump = format!(
        "new Promise((done) => {{ const begun = performance.now(); page.seek({second}); \
         const look = () => {{ const mm = Number(document.getElementById('true').textContent); \
         if (page.time() === ({second}).toFixed(3) && Number.isFinite(mm) && Number.isFinite(page.value('object_1'))) \
         requestAnimationFrame(() => done([performance.now() - begun, Number(document.getElementById('true').textContent)])); \
         else requestAnimationFrame(look); }}; look(); }})"
    );
    let answer = browser.evaluate(window, &jump);
    [0, 1].map(|at| answer[at].as_f64().expect("a number"))
}

/// Two peers on clocks of their own, merged and opened: what the page says is what the columns of both say.
#[test]
fn a_merge_is_opened() {
    let folder = fresh("merge");
    let [one, two, out] = ["one", "two", "both"].map(|name| folder.join(format!("{name}.mcap")));
    peer(0, &one);
    peer(1, &two);
    let merged = cohold(&["recording", "merge", text(&one), text(&two), text(&out)]).output().expect("cohold runs");
    assert!(merged.status.success(), "{}", String::from_utf8_lossy(&merged.stderr));
    let play = Play::start(&["--open", text(&out)]);
    let mut browser = Browser::start(folder.join("profile"));
    let page = browser.open(&play.addresses[0]);
    browser.wait(&page, "document.body.classList.contains('recording') && Number.isFinite(page.value('object_1'))");
    for second in [2.0, 5.5, 7.321, 12.0, 20.9] {
        let [_, mm] = jump(&mut browser, &page, second);
        let apart = 1e3 * (course(0, second).0 - course(1, second).0).abs();
        assert!((mm - apart).abs() <= 0.01 * apart + 0.002, "at {second} s: {mm} and {apart} mm");
        agrees(&mut browser, &page);
    }
    // Whose it is, when it was and under which law stands above what is exported; what a recording cannot do is not there.
    let svg = browser.evaluate(&page, "page.asSvg()");
    let svg = svg.as_str().expect("text");
    assert!(
        svg.contains("both.mcap, of peer 1 and peer 2: pair, law self-timed") && svg.contains("2023-11-14"),
        "{}",
        &svg[..600]
    );
    let shown = "[...document.querySelectorAll('button, select, input')].filter((e) => e.checkVisibility()).map((e) => e.id || e.textContent)";
    let shown = browser.evaluate(&page, &format!("{shown}.sort().join()"));
    assert_eq!(shown, "closer,csv,farther,packet-back,packet-on,pause,png,speed,svg,tick-back,tick-on");
    assert_eq!(browser.evaluate(&page, "document.getElementById('hand').checkVisibility()"), false);
    browser.picture(&page, &folder.join("../merge.png"));
    let complaints = browser.complaints(&[&page]);
    assert!(complaints.is_empty(), "{complaints:?}");

    // Its end cut off, what is whole is shown, and said to be cut; what is no recording is refused by name.
    let bytes = std::fs::read(&out).expect("a file");
    let (cut, none) = (folder.join("cut.mcap"), folder.join("none.mcap"));
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("a file");
    let said = cohold(&["play", "--open", text(&cut), "--seconds", "0.1"]).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success() && error.contains("cut.mcap: the recording was cut"), "{error}");
    std::fs::write(&none, "no recording").expect("a file");
    for (file, why) in [(&none, "this is no recording"), (&folder.join("away.mcap"), "cannot read")] {
        let said = cohold(&["play", "--open", text(file)]).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&said.stderr);
        let named = error.contains(text(file)) && error.contains(why);
        assert!(said.status.code() == Some(2) && named && error.trim().lines().count() == 1, "{error}");
    }
}

/// A recording of a run that faulted opens at its fault: the bar says which one in red, marks stand where something happened, and keys go from
/// one to the next.
#[test]
fn a_fault_is_opened() {
    let folder = fresh("fault");
    let file = folder.join("fault.mcap");
    let pushes = ["--set=user.1.push_n=5", "--set=user.2.push_n=-5", "--set=safety.max_speed_m_per_s=0.2"];
    let run = cohold(&["cooperate", "--json", "--scene=any-network", "--seconds=2"])
        .args(pushes)
        .arg("--record")
        .arg(&file)
        .output();
    assert_eq!(run.expect("cohold runs").status.code(), Some(1));
    let play = Play::start(&["--open", text(&file)]);
    let mut browser = Browser::start(folder.join("profile"));
    let page = browser.open(&play.addresses[0]);
    let bar = "document.getElementById('status')";
    browser.wait(
        &page,
        &format!("{bar}.textContent.startsWith('peer 1 has stopped: its device moved faster than it may')"),
    );
    browser.wait(
        &page,
        &format!("{bar}.classList.contains('bad') && page.value('fault_1') === 3 && page.value('fault_1', 1) === 0"),
    );
    browser.wait(
        &page,
        "document.getElementById('happened').textContent.includes('both peers: peer 1 stopped at 0.007 s: Overspeed')",
    );
    let marks = "[...document.querySelectorAll('#track .mark')]";
    browser.wait(&page, &format!("{marks}.some((mark) => mark.classList.contains('bad') && mark.offsetWidth > 0)"));
    browser.picture(&page, &folder.join("../fault.png"));
    // Before it, the motors ran.
    browser.evaluate(&page, "document.getElementById('scrub').focus()");
    browser.key(&page, "ArrowLeft");
    browser.wait(
        &page,
        &format!("!{bar}.classList.contains('bad') && {bar}.textContent.startsWith('fault.mcap, of both peers')"),
    );
    let [before] = browser.numbers(&page, "[page.moment()]");
    browser.key(&page, "Home");
    browser.wait(&page, "page.moment() === 0");
    browser.key(&page, "n");
    browser.wait(&page, &format!("page.moment() === {before} + 1"));
    let complaints = browser.complaints(&[&page]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// Ten minutes of two peers over bursts of 200 ms: any second is there soon, and is what the recording's own columns say.
#[test]
fn ten_minutes_are_opened() {
    let folder = fresh("ten-minutes");
    let (file, table) = (folder.join("bursts.mcap"), folder.join("bursts.csv"));
    let scene =
        ["cooperate", "--scene", "any-network", "--set", "network.loss=0.1", "--set", "network.loss_burst_packets=200"];
    let hand = |n: u8| {
        [("push_n", "0.5"), ("arm_stiffness_n_per_m", "20"), ("arm_damping_n_s_per_m", "1")]
            .map(|(key, x)| format!("--set=user.{n}.{key}={x}"))
    };
    let hands = [hand(1), hand(2)].concat();
    let hands: Vec<&str> = hands.iter().map(String::as_str).collect();
    let swing = ["--set", "user.1.sine_n=0.5", "--set", "user.2.pulse_n=2", "--seconds", "600", "--json"];
    let run = cohold(&[&scene[..], &hands[..], &swing[..], &["--record", text(&file)]].concat())
        .output()
        .expect("cohold runs");
    assert!(file.exists(), "{}", String::from_utf8_lossy(&run.stderr));
    let made = cohold(&["recording", "convert", text(&file), text(&table)]).output().expect("cohold runs");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    // From the raw columns, by their time.
    let raw = std::fs::read_to_string(&table).expect("a table");
    let mut lines = raw.lines();
    let head: Vec<&str> = lines.next().expect("a heading").split(',').collect();
    let at = |name: &str| head.iter().position(|known| *known == name).expect("a column");
    let (time, one, two) = (at("time_s"), at("object_1_m"), at("object_2_m"));
    let number = |line: &str, at: usize| line.split(',').nth(at).and_then(|x| x.parse::<f64>().ok()).expect("a number");
    let raw: Vec<[f64; 2]> =
        lines.map(|line| [number(line, time), 1e3 * (number(line, one) - number(line, two)).abs()]).collect();
    assert!(raw.len() > 590_000, "{}", raw.len());

    let opening = Instant::now();
    let play = Play::start(&["--open", text(&file)]);
    println!("ten minutes opened in {:.1} s", opening.elapsed().as_secs_f64());
    let mut browser = Browser::start(folder.join("profile"));
    let page = browser.open(&play.addresses[0]);
    browser.wait(&page, "document.body.classList.contains('recording') && Number.isFinite(page.value('object_1'))");
    // It opens where the copies were farthest apart.
    let [begin] = browser.numbers(&page, "[page.moment()]");
    let most_mm = raw.iter().map(|[_, mm]| *mm).fold(0.0, f64::max);
    assert!(raw[begin as usize][1] > 0.999 * most_mm, "{begin}: {:?} and {most_mm}", raw[begin as usize]);
    let mut took: Vec<f64> = Vec::new();
    for second in [300.0, 1.0, 599.0, 123.456, 450.001, 30.5, 512.0, 77.0, 588.8, 204.25, 1.5, 360.0] {
        let [ms, mm] = jump(&mut browser, &page, second);
        let row = raw.partition_point(|[time, _]| *time < second - 1e-6);
        assert!((mm - raw[row][1]).abs() <= 0.01 * raw[row][1] + 6e-4, "at {second} s: {mm} and {:?}", raw[row]);
        took.push(ms);
    }
    took.sort_by(f64::total_cmp);
    println!(
        "any second of ten minutes: {:.0} ms at the median, {:.0} ms at the most",
        took[took.len() / 2],
        took[took.len() - 1]
    );
    assert!(took.iter().all(|ms| *ms < 10_000.0), "{took:?}");
    browser.picture(&page, &folder.join("../ten-minutes.png"));
    // The last moment of all, by a key; then what was there at the beginning.
    browser.evaluate(&page, "document.getElementById('scrub').focus()");
    browser.key(&page, "End");
    browser.wait(&page, "Number(page.time()) > 599.9 && Number.isFinite(page.value('object_2'))");
    browser.key(&page, "Home");
    browser.wait(&page, "page.moment() === 0 && Number.isFinite(page.value('object_1'))");
    // Played, it goes on by itself.
    browser.key(&page, " ");
    browser.wait(&page, "page.moment() > 500");
    let complaints = browser.complaints(&[&page]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
