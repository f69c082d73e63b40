//! What a newcomer meets: three pictures with one control each and a workshop behind them, by keyboard alone.

use std::time::{Duration, Instant};

use serde_json::json;

use super::{Browser, Play, Window, click, folder, set};

const WIDE: (u32, u32) = (1440, 900);

fn open(browser: &mut Browser, play: &Play) -> Window {
    let window = browser.open(&play.person(1));
    let size = json!({ "width": WIDE.0, "height": WIDE.1, "deviceScaleFactor": 1, "mobile": false });
    browser.call(&window, "Emulation.setDeviceMetricsOverride", size);
    window
}

/// Goes to an element by Tab alone.
fn tab_to(browser: &mut Browser, window: &Window, id: &str, back: bool) {
    for _ in 0..60 {
        if browser.evaluate(window, "document.activeElement?.id") == id {
            return;
        }
        browser.press(window, "Tab", back);
    }
    panic!("no Tab leads to {id}");
}

fn text(browser: &mut Browser, window: &Window, selector: &str) -> String {
    let found = browser.evaluate(window, &format!("document.querySelector('{selector}').textContent"));
    found.as_str().expect("a text").to_owned()
}

/// The picture in both colour schemes, as a person would look at it.
fn pictures(browser: &mut Browser, window: &Window, name: &str) {
    for scheme in ["light", "dark"] {
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        browser.call(window, "Emulation.setEmulatedMedia", media);
        browser.picture(window, &folder().join(format!("{name}-{scheme}.png")));
    }
}

/// What says how it stands is red, or it is not.
fn is_red(browser: &mut Browser, window: &Window) -> bool {
    let expression = "(() => { const probe = document.createElement('i'); probe.className = 'bad'; document.body.append(probe); \
         const red = getComputedStyle(probe).color; probe.remove(); return getComputedStyle(document.getElementById('status')).color === red; })()";
    browser.evaluate(window, expression) == true
}

/// Millimetres between the copies as the lens draws them, by its own ruler: from the middle of one to that of the other, over how long a
/// millimetre is there.
const BY_THE_LENS: &str = "(() => { const lens = document.querySelector('#delay-picture .lens'); \
     const x = (n) => Number(lens.querySelector(`.middle${n}`).getAttribute('d').match(/^M(\\S+)/)[1]); \
     const marks = [...lens.querySelectorAll('.number')].map((e) => [Number(e.getAttribute('x')), Number(e.textContent.replace('−', '-'))]); \
     const [first, last] = [marks[0], marks.at(-1)]; const mm = (last[0] - first[0]) / (last[1] - first[1]); \
     return [Math.abs(x(2) - x(1)) / mm, mm]; })()";

/// Keeps the longest arrow of hand 1 in pixels and the widest gap under the lens in millimetres that any frame showed.
const FIRST_TOUCH: &str = "window.touch = [0, 0]; (function look() { \
     const arrow = document.querySelector('#pair .peer1 .arrow.hand').getBoundingClientRect().width; \
     const gap = parseFloat(document.querySelector('#pair .lens .gap').textContent) || 0; \
     touch = [Math.max(touch[0], arrow), Math.max(touch[1], gap)]; requestAnimationFrame(look); })()";

/// What the picture of the delay says at this delay, once its line is at rest: the pull, N, the spring that the line is, N/m, and the gap, mm.
fn delay_says(browser: &mut Browser, window: &Window, ms: u32) -> [f64; 3] {
    let says = format!(
        "(document.getElementById('delay-says').textContent.match(/ pull one object apart with (\\S+) N\\. Over a delay of {ms} ms the line between \
         them gives way like a spring of (\\d+) N\\/m, so the copies stand (\\S+) mm apart\\. A longer line is a softer spring/) ?? []).slice(1).map(Number)"
    );
    browser.numbers(window, &says)
}

/// Nothing asked for, the page opens with two hands that pull an object apart. The lens enlarges the gap twenty times, beside a ruler that
/// says so, and a later delay, set by keys, makes it wider: the line is a spring, softer the longer it is. Stopped, it claims nothing of that.
#[test]
fn the_delay_is_seen_under_a_lens() {
    let play = Play::plainly(&[]);
    let mut browser = Browser::start(folder().join("delay"));
    let one = open(&mut browser, &play);
    browser.wait(&one, "page.environment() === 'delay' && Number.isFinite(page.value('object_2', 3000))");
    let seen = |browser: &mut Browser| -> [f64; 3] {
        let expression = format!(
            "(() => {{ const [seen, mm] = {BY_THE_LENS}; return [seen, mm, 1e3 * Math.abs(page.value('object_1') - page.value('object_2'))]; }})()"
        );
        browser.numbers(&one, &expression)
    };
    let [by_lens, enlarged, apart] = seen(&mut browser);
    assert!((enlarged - 20.0).abs() < 0.1, "{enlarged}");
    assert!((by_lens - apart).abs() < 0.3 && by_lens > 0.8, "{by_lens} {apart}");
    assert!(text(&mut browser, &one, "#delay-picture .lens .power").ends_with("×20"));
    assert!(!is_red(&mut browser, &one));
    let [pull, spring, gap] = delay_says(&mut browser, &one, 60);
    // 2/K_T + T/b, and the line a few ticks longer than the delay; what is written is rounded.
    let by_settings = 1.0 / (2.0 / 10_000.0 + 0.0625 / 60.0);
    assert!((1.0..2.0).contains(&pull) && (spring / by_settings - 1.0).abs() < 0.1, "{pull} {spring}");
    assert!((1e3 * pull / spring - gap).abs() < 0.2, "{pull} {spring} {gap}");
    // Whose force an arrow is stands beside it.
    let owners = browser.evaluate(
        &one,
        "[...document.querySelectorAll('#delay-picture text:not([hidden])')].map((e) => e.textContent).filter((t) => / N$/.test(t)).join()",
    );
    let owners = owners.as_str().unwrap_or_default().to_owned();
    assert!(owners.contains("simulated hand 1: 1.") && owners.contains("coupling on 2: 1."), "{owners}");
    pictures(&mut browser, &one, "delay");

    tab_to(&mut browser, &one, "story-delay", false);
    browser.press(&one, "End", false);
    let [_, softer, wider] = delay_says(&mut browser, &one, 150);
    assert!(softer < 0.5 * spring && wider > 2.0 * gap, "{softer} {wider}");
    browser.wait(&one, &format!("{BY_THE_LENS}[0] > 1.6 * {by_lens} && {BY_THE_LENS}[0] < 12"));
    browser.press(&one, "Home", false);
    browser.wait(&one, &format!("{BY_THE_LENS}[0] < 0.7 * {by_lens}"));

    // A person takes a hand as well.
    tab_to(&mut browser, &one, "hand", false);
    for _ in 0..10 {
        browser.press(&one, "ArrowRight", false);
    }
    browser.wait(&one, "page.value('wanted_1') > page.value('device_1') && page.value('hand_1') > 0.1");

    click(&mut browser, &one, "stop");
    let says = |text: &str| format!("document.getElementById('delay-says').textContent.{text}");
    browser.wait(&one, &says("startsWith('Stopped: the motors are off, and no hand reaches the object now.')"));
    assert_eq!(browser.evaluate(&one, &says("match(/ pull| spring/)")), json!(null));
    browser.wait(&one, "page.value('coordination_1') === 0 && page.value('contact_1') === 0");
    click(&mut browser, &one, "start");
    delay_says(&mut browser, &one, 0);
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// Made stiffer than its edge a peer stops itself: the picture stands, shows both copies whatever they did, replays the last two seconds ten
/// times slower, again and again, and says what to change; a softer coupling begins anew.
#[test]
fn too_stiff_is_replayed() {
    let play = Play::plainly(&[]);
    let mut browser = Browser::start(folder().join("stiff"));
    let one = open(&mut browser, &play);
    browser.wait(&one, "page.environment() === 'delay'");
    tab_to(&mut browser, &one, "to-too-stiff", false);
    browser.press(&one, "Enter", false);
    browser.wait(&one, "page.environment() === 'too-stiff' && Number.isFinite(page.value('object_1', 500))");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('it holds')");
    assert!(!is_red(&mut browser, &one));
    // Where the edge is, the analyser has said; the range marks it.
    browser.wait(&one, "!document.getElementById('stiff-edge').hidden");
    pictures(&mut browser, &one, "stiff");

    tab_to(&mut browser, &one, "story-stiffness", false);
    browser.press(&one, "End", false);
    browser.wait(&one, "document.getElementById('status').textContent.includes('stopped itself')");
    assert!(is_red(&mut browser, &one));
    let says = text(&mut browser, &one, "#stiff-says");
    assert!(says.starts_with("Peer ") && says.contains("Make it softer: below 3") && !says.contains('_'), "{says}");
    let [stood] = browser.numbers(&one, "[page.value('object_1')]");

    // Ten times slower: in a second of the clock about a tenth of one is replayed, whatever the frames do.
    let replayed = "new Promise((done) => { const from = [performance.now(), page.replayed()]; \
         setTimeout(() => requestAnimationFrame(() => done([performance.now() - from[0], from[1] - page.replayed()])), 1000); })";
    let slow = (0..30).any(|_| {
        let [ms, ticks]: [f64; 2] = browser.numbers(&one, replayed);
        // Not over the end of a round, where it begins again.
        ticks > 0.0 && (0.07..0.13).contains(&(ticks / ms))
    });
    assert!(slow, "it is not replayed ten times slower");
    // Both copies stay in the picture all the way, and what is written of them are millimetres.
    for _ in 0..20 {
        let inside = browser.evaluate(
            &one,
            "(() => { const box = document.getElementById('stiff-picture').getBoundingClientRect(); \
             return [...document.querySelectorAll('#stiff-picture .copy')].every((copy) => { const r = copy.getBoundingClientRect(); \
             const at = r.x + r.width / 2; return r.width > 4 && at > box.x && at < box.right && r.y > box.y && r.bottom < box.bottom; }); })()",
        );
        assert_eq!(inside, true);
        std::thread::sleep(Duration::from_millis(100));
    }
    let apart = text(&mut browser, &one, "#stiff-picture .lens .gap");
    let mm: f64 = apart.split(' ').next().and_then(|number| number.parse().ok()).expect("millimetres");
    assert!(mm < 2000.0, "{apart}");
    pictures(&mut browser, &one, "stiff-fault");
    // Round and round: it comes to its end and begins again.
    browser.wait(&one, "page.replayed() < 30");
    browser.wait(&one, "page.replayed() > 100");
    assert_eq!(browser.numbers(&one, "[page.value('object_1')]"), [stood]);

    browser.press(&one, "Home", false);
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('it holds')");
    browser.wait(&one, "Number.isNaN(page.replayed()) && page.value('restarts') > 0");
    assert!(!is_red(&mut browser, &one));
    // Past the edge again, and begun again by its button: it stops again.
    browser.press(&one, "End", false);
    browser.wait(&one, "page.replayed() >= 0");
    let [restarts] = browser.numbers(&one, "[page.value('restarts')]");
    tab_to(&mut browser, &one, "stiff-again", false);
    browser.press(&one, "Enter", false);
    browser.wait(&one, &format!("page.value('restarts') > {restarts} && page.replayed() >= 0"));
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// The workshop shows every force that acts and whose it is, the first touch, and a cut; how it stands is red when copies are apart whatever
/// the verdict on the settings; and what a mode does not need is not there.
#[test]
fn the_workshop_says_what_acts() {
    let play = Play::plainly(&[]);
    let mut browser = Browser::start(folder().join("workshop"));
    let one = open(&mut browser, &play);
    browser.wait(&one, "page.environment() === 'delay'");
    tab_to(&mut browser, &one, "to-workshop", false);
    browser.press(&one, "Enter", false);
    browser.wait(&one, "page.environment() === 'pair' && Number.isFinite(page.value('object_1', 500))");
    // The picture's scene was its own.
    browser.wait(&one, "document.getElementById('delay').value === '8'");

    // The first touch: four millimetres are an arrow, and a gap under the lens. The object soon follows the hand, and both are small again: what
    // was drawn in any frame counts, and the hand goes there and back until a machine that is busy has drawn one of them.
    tab_to(&mut browser, &one, "hand", false);
    browser.evaluate(&one, FIRST_TOUCH);
    let start = Instant::now();
    for key in ["ArrowRight", "ArrowLeft"].into_iter().cycle() {
        browser.press(&one, key, false);
        browser.press(&one, key, false);
        std::thread::sleep(Duration::from_millis(300));
        let [arrow, gap] = browser.numbers(&one, "touch");
        if arrow > 20.0 && gap > 0.0 {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "an arrow of {arrow} pixels, a gap of {gap} mm");
    }
    let plots = "[...document.querySelectorAll('#strips canvas')].slice(0, 2)";
    browser
        .wait(&one, &format!("{plots}.every((plot) => plot.getBoundingClientRect().bottom + scrollY <= innerHeight)"));
    pictures(&mut browser, &one, "workshop");

    // The scene's users push with nobody's hand on: drawn, and listed.
    browser.evaluate(&one, "document.getElementById('let-go').click()");
    browser.evaluate(&one, "page.command('anyway scene paper-5.2-passive-wave-16ms')");
    browser.wait(&one, "Math.abs(page.value('push_1', 200) - 1) < 1e-3 && page.value('hand_1') === 0");
    browser.wait(&one, "document.querySelector('#pair .peer1 .arrow.push').getBoundingClientRect().width > 20");
    browser.wait(&one, "Math.abs(parseFloat(document.getElementById('pushes').textContent) - 1) < 0.01");

    // Cut, what couples the copies hangs down, and it says so.
    tab_to(&mut browser, &one, "cut", false);
    browser.press(&one, "Enter", false);
    browser.wait(&one, "document.querySelector('#pair .coupling.broken') && !document.querySelector('#pair .cut').hasAttribute('hidden')");
    assert!(is_red(&mut browser, &one));
    pictures(&mut browser, &one, "workshop-cut");
    click(&mut browser, &one, "cut");
    browser.wait(&one, "!document.querySelector('#pair .coupling.broken')");

    // Waves that are lost leave the copies apart for good: red, though the settings are stable.
    browser.evaluate(
        &one,
        "page.command('anyway scene paper-5.2-passive-wave-16ms network.loss=0.5 network.loss_burst_packets=100')",
    );
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('the copies are ')");
    assert!(is_red(&mut browser, &one));
    browser.wait(&one, "document.getElementById('verdict').textContent.startsWith('stable')");
    browser.wait(&one, "document.getElementById('seen').textContent.includes('the copies are ')");

    // Squash has no law and no K_T.
    let there = |id: &str| format!("document.getElementById('{id}').offsetParent !== null");
    browser.wait(&one, &format!("{} && {}", there("stiffness"), there("law")));
    set(&mut browser, &one, "environment", "squash");
    browser.wait(&one, "page.environment() === 'squash'");
    browser.wait(&one, &format!("!({}) && !({}) && {}", there("stiffness"), there("law"), there("delay")));
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
