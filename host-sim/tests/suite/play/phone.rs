//! A visitor's phone: 390 × 844 with touch, at the address that `play --lan` gives a hand. What is shown is measured, and the hand moved by touch.

use serde_json::{Value, json};

use super::socket::Socket;
use super::{Browser, Play, Window, click, folder, middle};

/// This window is a phone: small, dense, touched, with or without a dark scheme.
fn as_phone(browser: &mut Browser, window: &Window, scheme: &str) {
    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.call(window, "Emulation.setDeviceMetricsOverride", phone);
    browser.call(window, "Emulation.setTouchEmulationEnabled", json!({ "enabled": true, "maxTouchPoints": 5 }));
    let scheme = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
    browser.call(window, "Emulation.setEmulatedMedia", scheme);
    browser.wait(window, "document.documentElement.clientWidth === 390");
}

fn touch(browser: &mut Browser, window: &Window, kind: &str, points: Value) {
    browser.call(window, "Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
}

/// What of this is to be seen, of which each is on the screen with a size.
const SHOWN: &str = "(selector) => [...document.querySelectorAll(selector)].filter((e) => e.checkVisibility({ visibilityProperty: true }) \
     && e.getBoundingClientRect().width > 0)";

/// Controls that are too small, and texts: each with its size in pixels, of texts in a drawing times its scale.
const TOO_SMALL: &str = "(() => { const shown = SHOWN; \
     const controls = shown('button, select, input, summary, label.button, a, [role=slider]').map((e) => [e.id || e.textContent, \
       Math.min(e.getBoundingClientRect().width, e.getBoundingClientRect().height)]).filter(([, size]) => size < 43.99); \
     const words = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()); \
     const texts = shown('body *').filter(words).map((e) => [e.textContent.trim().slice(0, 30), \
       parseFloat(getComputedStyle(e).fontSize) * (e.ownerSVGElement?.getScreenCTM().a ?? 1)]).filter(([, size]) => size < 12); \
     return [...controls, ...texts].map(([what, size]) => `${what}: ${size} px`); })()";

fn too_small(browser: &mut Browser, window: &Window) -> Value {
    browser.evaluate(window, &TOO_SMALL.replace("SHOWN", SHOWN))
}

/// Left, top, width and height of the drawing.
fn scene(browser: &mut Browser, window: &Window) -> [f64; 4] {
    place(browser, window, "scene")
}

/// The same of the part of the page with this name.
fn place(browser: &mut Browser, window: &Window, id: &str) -> [f64; 4] {
    let rectangle = format!("document.getElementById('{id}').getBoundingClientRect()");
    browser.numbers(window, &format!("(({{ x, y, width, height }}) => [x, y, width, height])({rectangle})"))
}

#[test]
fn a_phone_holds_the_second_hand() {
    let play = Play::start(&["--lan", "127.0.0.1", "--partner", "follows", "--environment", "pair"]);
    let mut browser = Browser::start(folder().join("phone"));
    // The operator's page shows the code and who is there.
    let operator = browser.open(&play.addresses[0]);
    let people = "document.getElementById('people').textContent";
    browser.wait(&operator, &format!("{people} === 'hand 1: this window · hand 2: nobody'"));
    click(&mut browser, &operator, "join");
    browser.evaluate(&operator, "document.getElementById('join').open = true");
    let [code] =
        browser.numbers(&operator, "[document.querySelector('#join-code path').getBoundingClientRect().width]");
    assert!(code > 150.0, "{code}");
    assert_eq!(browser.evaluate(&operator, "document.getElementById('join-address').textContent"), play.addresses[5]);
    browser.picture(&operator, &folder().join("phone-operator.png"));

    let phone = browser.open(&play.addresses[5]);
    for scheme in ["dark", "light"] {
        as_phone(&mut browser, &phone, scheme);
        browser.wait(&phone, "page.frames() > 20 && Number.isFinite(page.value('device_2'))");
        let [x, y, width, height] = scene(&mut browser, &phone);
        assert!(x.abs() < 0.01 && (width - 390.0).abs() < 0.01, "it fills the width: {x} {width}");
        assert!(height >= 844.0 / 3.0 && y + height < 844.0, "a third of the height, without scrolling: {y} {height}");
        let small = too_small(&mut browser, &phone);
        assert_eq!(small, json!([]), "{small}");
        assert_eq!(browser.evaluate(&phone, "document.documentElement.scrollWidth <= 390"), true);
        browser.picture(&phone, &folder().join(format!("phone-hand-{scheme}.png")));
    }
    browser.wait(&operator, &format!("{people} === 'hand 1: this window · hand 2: somebody is there'"));
    // Nothing is offered but what a hand can do.
    let controls = format!("({SHOWN})('button, select, input, summary, label.button, a').map((e) => e.id)");
    assert_eq!(browser.evaluate(&phone, &controls), json!(["stop"]));

    // A finger anywhere in the drawing takes the hand, here in a corner of it, and the page does not scroll.
    let from = |browser: &mut Browser| browser.numbers(&phone, "[page.value('object_2'), scene.getScreenCTM().a]");
    let [object, per_mm] = from(&mut browser);
    let [_, y, _, height] = scene(&mut browser, &phone);
    let corner = [30.0, y + height - 20.0];
    touch(&mut browser, &phone, "touchStart", json!([{ "x": corner[0], "y": corner[1] }]));
    for step in 1..=40 {
        let step = f64::from(step);
        touch(
            &mut browser,
            &phone,
            "touchMove",
            json!([{ "x": corner[0] + per_mm * step, "y": corner[1] - 3.0 * step }]),
        );
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
    browser.wait(&operator, &format!("page.value('object_2') > {object} + 0.028 && page.value('hand_2') !== 0"));
    assert_eq!(browser.evaluate(&phone, "[scrollX, scrollY]"), json!([0, 0]));
    browser.picture(&phone, &folder().join("phone-holds.png"));
    touch(&mut browser, &phone, "touchEnd", json!([]));
    browser.wait(&operator, "Number.isNaN(page.value('wanted_2'))");
    let complaints = browser.complaints(&[&operator, &phone]);
    assert!(complaints.is_empty(), "{complaints:?}");

    // Its screen goes off while it holds: nothing is said any more, and the hand has let go. On again, the page is back without being loaded.
    let status = "document.getElementById('status').textContent";
    browser.evaluate(&phone, "window.same = true");
    touch(&mut browser, &phone, "touchStart", json!([{ "x": corner[0], "y": corner[1] }]));
    browser.wait(&operator, "Number.isFinite(page.value('wanted_2'))");
    // A window that is said to be in front is never frozen.
    browser.call(&phone, "Emulation.setFocusEmulationEnabled", json!({ "enabled": false }));
    browser.call(&phone, "Page.setWebLifecycleState", json!({ "state": "frozen" }));
    browser.wait(&operator, "Number.isNaN(page.value('wanted_2'))");
    browser.call(&phone, "Page.setWebLifecycleState", json!({ "state": "active" }));
    browser.call(&phone, "Emulation.setFocusEmulationEnabled", json!({ "enabled": true }));
    touch(&mut browser, &phone, "touchEnd", json!([]));
    browser.wait(&operator, &format!("{people}.endsWith('hand 2: somebody is there')"));
    browser.wait(&phone, &format!("window.same && {status} === 'another person has the other hand'"));

    // It cannot cut the cable: the order over its own line is refused by the program.
    browser.evaluate(&phone, "page.command('cut')");
    browser.wait(
        &phone,
        "document.getElementById('refused').textContent === \"only the operator's address may order that\"",
    );
    assert_eq!(browser.evaluate(&operator, "document.getElementById('cut').getAttribute('aria-pressed')"), "false");
    // It can stop.
    click(&mut browser, &phone, "stop");
    browser.wait(&operator, "document.getElementById('status').textContent.startsWith('stopped: motors are off')");

    // Another window takes the hand; a tap takes it back, without loading anything again.
    let mut other = Socket::open(&play.addresses[5]).expect("it is let in");
    other.points(0.0);
    browser.wait(&phone, &format!("{status} === 'closed: another window took this hand'"));
    click(&mut browser, &phone, "rejoin");
    browser.wait(
        &phone,
        &format!("window.same && !{status}.startsWith('closed') && document.getElementById('rejoin').hidden"),
    );

    // The end of the run is said, and what an old address is.
    let old = play.addresses[5].clone();
    drop(play);
    browser.wait(
        &phone,
        &format!("{status}.startsWith('no answer from the program: the network is lost, or it has ended')"),
    );
    let port = old.split([':', '/']).nth(4).expect("a port").to_owned();
    // The next run is where that one was, and has other keys.
    let _next = Play::start(&["--port", &port]);
    browser.wait(
        &phone,
        &format!("window.same && {status}.startsWith('this link belongs to a run that has ended: scan the new code')"),
    );
}

/// The operator's page on a phone, and what only watches: large enough, and nothing scrolls sideways.
#[test]
fn every_role_fits_a_phone() {
    let play = Play::start(&["--lan", "127.0.0.1", "--environment", "bad-network"]);
    let mut browser = Browser::start(folder().join("phone-roles"));
    for (at, role) in [(0, "operator"), (5, "hand"), (6, "watch")] {
        let window = browser.open(&play.addresses[at]);
        as_phone(&mut browser, &window, "light");
        browser.wait(&window, "page.environment() === 'bad-network' && page.frames() > 20");
        let small = too_small(&mut browser, &window);
        assert_eq!(small, json!([]), "{role}: {small}");
        browser.wait(&window, "document.documentElement.scrollWidth <= 390");
        browser.picture(&window, &folder().join(format!("phone-laws-{role}.png")));
        if role == "hand" {
            // Any of the three drawings takes the hand of all.
            let [x, y] = browser.numbers(
                &window,
                "(({ x, y, width, height }) => [x + width / 4, y + height / 2])(document.querySelector('.lane svg').getBoundingClientRect())",
            );
            touch(&mut browser, &window, "touchStart", json!([{ "x": x, "y": y }]));
            browser.wait(&window, "Number.isFinite(page.value('wanted_2'))");
            touch(&mut browser, &window, "touchEnd", json!([]));
            browser.wait(&window, "Number.isNaN(page.value('wanted_2'))");
        }
    }
    let operator = browser.open(&play.addresses[3]);
    browser.wait(&operator, "page.frames() > 5");
    let order = "[...document.getElementById('environment').options].map(({ value }) => value)";
    let names = browser.evaluate(&operator, order);
    let window = browser.open(&play.addresses[5]);
    as_phone(&mut browser, &window, "light");
    let pictures = [("delay", "delay-picture"), ("too-stiff", "stiff-picture"), ("bad-network", "lanes")];
    let names = names.as_array().expect("names").iter().filter_map(Value::as_str).map(|name| (name, "scene"));
    for (name, drawing) in names.chain(pictures) {
        browser.evaluate(&operator, &format!("page.command('show {name}')"));
        browser.wait(&window, &format!("page.environment() === '{name}'"));
        std::thread::sleep(std::time::Duration::from_millis(400));
        let small = too_small(&mut browser, &window);
        assert_eq!(small, json!([]), "{name}: {small}");
        assert_eq!(browser.evaluate(&window, "document.documentElement.scrollWidth <= 390"), true, "{name}");
        if name != "bad-network" {
            let [_, _, width, height] = place(&mut browser, &window, drawing);
            assert!((width - 390.0).abs() < 0.01 && height >= 844.0 / 3.0, "{name}: {width} {height}");
        }
        let [x, y] = middle(&mut browser, &window, drawing);
        assert!(x > 0.0 && y > 0.0);
        browser.picture(&window, &folder().join(format!("phone-{name}.png")));
    }
}
