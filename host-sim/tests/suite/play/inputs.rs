//! Every way to take the hand: finger, pen and keys carry the object as the mouse does, and what is let go is let go.

use serde_json::json;

use super::{Browser, Play, Window, click, folder, middle};

/// Until the object has been carried this far from where it was, mm.
fn wait_for_way(browser: &mut Browser, window: &Window, from: f64, mm: f64) {
    let (sign, at) = (mm.signum(), from + 0.7e-3 * mm);
    browser.wait(window, &format!("{sign} * (page.value('object_1') - {at}) > 0"));
}

fn object(browser: &mut Browser, window: &Window) -> f64 {
    let [at] = browser.numbers(window, "[page.value('object_1')]");
    at
}

#[test]
fn finger_pen_and_keys_carry_the_object() {
    let play = Play::start(&["--partner", "follows"]);
    let mut browser = Browser::start(folder().join("inputs"));
    let one = browser.open(&play.addresses[0]);
    browser.wait(&one, "page.frames() > 20 && page.value('device_1', 500) === 0");
    let [per_mm] = browser.numbers(&one, "[scene.getScreenCTM().a]");

    // A finger; the page does not scroll away under it.
    let from = object(&mut browser, &one);
    let [x, y] = middle(&mut browser, &one, "hand");
    let touch = |browser: &mut Browser, kind: &str, points: serde_json::Value| {
        browser.call(&one, "Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
    };
    touch(&mut browser, "touchStart", json!([{ "x": x, "y": y }]));
    for step in 1..=40 {
        let along = x + per_mm * f64::from(step);
        touch(&mut browser, "touchMove", json!([{ "x": along, "y": y + f64::from(step) }]));
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
    wait_for_way(&mut browser, &one, from, 40.0);
    assert_eq!(browser.evaluate(&one, "scrollY"), 0);
    touch(&mut browser, "touchEnd", json!([]));
    browser.wait(&one, "Number.isNaN(page.value('wanted_1'))");

    // A pen.
    let from = object(&mut browser, &one);
    let [x, y] = middle(&mut browser, &one, "hand");
    let pen = |browser: &mut Browser, kind: &str, x: f64| {
        let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1, "pointerType": "pen" });
        browser.call(&one, "Input.dispatchMouseEvent", event);
    };
    pen(&mut browser, "mousePressed", x);
    for step in 1..=40 {
        pen(&mut browser, "mouseMoved", x - per_mm * f64::from(step));
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
    wait_for_way(&mut browser, &one, from, -40.0);
    pen(&mut browser, "mouseReleased", x - per_mm * 40.0);
    browser.wait(&one, "Number.isNaN(page.value('wanted_1'))");

    // Keys, and Home; what has lost the focus has let go.
    let from = object(&mut browser, &one);
    browser.evaluate(&one, "document.getElementById('hand').focus()");
    for _ in 0..10 {
        browser.key(&one, "ArrowRight");
    }
    wait_for_way(&mut browser, &one, from, 20.0);
    browser.key(&one, "Home");
    browser.wait(&one, "Math.abs(page.value('object_1')) < 0.004");
    browser.evaluate(&one, "document.getElementById('pause').focus()");
    browser.wait(&one, "Number.isNaN(page.value('wanted_1'))");

    // Stop is in reach however far one has scrolled.
    browser.evaluate(&one, "scrollTo(0, document.body.scrollHeight)");
    browser.wait(
        &one,
        "(() => { const r = document.getElementById('stop').getBoundingClientRect(); \
         return r.top >= 0 && r.bottom <= innerHeight; })()",
    );
    click(&mut browser, &one, "stop");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('stopped: motors are off')");
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
