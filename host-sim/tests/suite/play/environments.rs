//! Shared environments on the page: chosen there, seen in both windows, held by a mouse; and what cannot be shown says why.

use serde_json::json;

use super::{Browser, Play, Window, click, drag, folder, middle, set};

/// Shows an environment in both windows, from the first.
fn show(browser: &mut Browser, windows: [&Window; 2], name: &str, column: &str) {
    set(browser, windows[0], "environment", name);
    for window in windows {
        browser
            .wait(window, &format!("page.environment() === '{name}' && Number.isFinite(page.value('{column}', 200))"));
        assert_eq!(
            browser.evaluate(window, "getComputedStyle(document.getElementById('pair')).display"),
            "none",
            "{name}"
        );
    }
}

#[test]
fn shared_environments_are_shown_and_held() {
    let play = Play::start(&["--environment", "hub", "--partner", "follows"]);
    let mut browser = Browser::start(folder().join("environments"));
    let [one, two] = [1, 2].map(|person| browser.open(&play.person(person)));
    for window in [&one, &two] {
        browser.wait(window, "Number.isFinite(page.value('object_4', 200))");
    }

    // Four hands on one object: what one carries, all copies follow.
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    let at = drag(&mut browser, &one, hand, 60.0);
    browser.wait(&two, "[1, 2, 3, 4].every((n) => page.value(`object_${n}`) > 0.01) && page.value('hand_1') > 0.3");
    browser.picture(&one, &folder().join("hub.png"));
    browser.mouse(&one, "mouseReleased", at);

    // Squash: a hand runs where it is wanted and serves on its way; both windows see the ball.
    show(&mut browser, [&one, &two], "squash", "hand_4_x");
    browser.wait(&one, "page.value('next') === 1");
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    let before: [f64; 1] = browser.numbers(&one, "[page.value('hand_1_x')]");
    let at = drag(&mut browser, &one, hand, 60.0);
    browser.wait(&two, &format!("page.value('hand_1_x') > {} + 1.5", before[0]));
    browser.wait(&two, "page.value('stroke') >= 1 || page.value('rally') > 1");
    browser.picture(&one, &folder().join("squash.png"));
    browser.mouse(&one, "mouseReleased", at);

    // A static world: known, then felt along its wall, and the other visitor is seen.
    show(&mut browser, [&one, &two], "world", "device_1_x");
    browser.wait(&one, "page.value('felt_1') === 7 && Number.isFinite(page.value('seen_1_x'))");
    let hand = middle(&mut browser, &one, "hand");
    let [per_mm] = browser.numbers(&one, "[scene.getScreenCTM().a]");
    browser.mouse(&one, "mousePressed", hand);
    for step in 0..40 {
        let (along, down) = (0.5 * f64::from(step), f64::from(step));
        browser.mouse(&one, "mouseMoved", [hand[0] + per_mm * along, hand[1] + per_mm * down]);
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
    browser.wait(&two, "page.value('force_1_y') > 0.5 && page.value('device_1_y') < -0.055");
    browser.picture(&one, &folder().join("world.png"));
    browser.mouse(&one, "mouseReleased", hand);

    // One at a time: who takes it gets it, carries it, and leaves it for all to see; stop holds everybody.
    for name in ["lock", "ring"] {
        show(&mut browser, [&one, &two], name, "object_3_x");
        let taken = (0..20).any(|_| {
            let [x, y, mm] = browser.numbers(
                &one,
                "[scene.getScreenCTM().e + 1e3 * page.value('hand_1_x') * scene.getScreenCTM().a, \
                 scene.getScreenCTM().f - 1e3 * page.value('hand_1_y') * scene.getScreenCTM().d, scene.getScreenCTM().a]",
            );
            let [along, across] = browser.numbers(
                &one,
                "[1e3 * (page.value('object_1_x') - page.value('hand_1_x')), 1e3 * (page.value('object_1_y') - page.value('hand_1_y'))]",
            );
            browser.mouse(&one, "mousePressed", [x, y]);
            browser.mouse(&one, "mouseMoved", [x + mm * along, y - mm * across]);
            let taken = (0..60).any(|_| {
                std::thread::sleep(std::time::Duration::from_millis(50));
                browser.evaluate(&one, "page.value('state_1') === 2") == true
            });
            if taken {
                browser.picture(&one, &folder().join(format!("{name}.png")));
            }
            browser.mouse(&one, "mouseReleased", [x + mm * along, y - mm * across]);
            taken
        });
        assert!(taken, "{name}");
        browser.wait(&two, "page.value('version_2') > 0 && page.value('version_1') === page.value('version_3')");
    }
    click(&mut browser, &two, "stop");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('stopped')");
    browser.wait(&one, "page.value('hand_3_x') === page.value('hand_3_x', 300)");
    click(&mut browser, &two, "start");
    browser.wait(&one, "page.value('restarts') >= 1");

    // A law without a line that meets others is no hub's, and the page says so; what was shown goes on.
    browser.evaluate(&one, "page.command('anyway law power')");
    browser.wait(&one, "document.getElementById('law').value === 'power'");
    set(&mut browser, &one, "environment", "hub");
    browser.wait(&one, "document.getElementById('refused').textContent.length > 10");
    browser.wait(&one, "Number.isFinite(page.value('object_3_x'))");
    let csv = browser.evaluate(&one, "page.asCsv().split('\\n')[0]");
    assert!(
        csv.as_str().is_some_and(|head| head.starts_with("time_s,hand_1_x_m,") && head.ends_with(",restarts")),
        "{csv}"
    );
    let complaints = browser.complaints(&[&one, &two]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// Moves a mouse that holds a hand by so many millimetres of the drawing to the right and up, in steps of half a millimetre.
fn carry(browser: &mut Browser, window: &Window, [x, y]: [f64; 2], [right, up]: [f64; 2]) {
    let [per_mm] = browser.numbers(window, "[scene.getScreenCTM().a]");
    let steps = (2.0 * right.hypot(up)).ceil() as u32;
    for share in (1..=steps).map(|step| f64::from(step) / f64::from(steps)) {
        browser.mouse(window, "mouseMoved", [x + per_mm * share * right, y - per_mm * share * up]);
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
}

/// Two hands hold one object in the plane and in space; as many axes are shown as the scene says, and choosing them sets them.
#[test]
fn two_hands_hold_one_object_in_plane_and_space() {
    let play = Play::start(&["--scene", "plane", "--partner", "follows"]);
    let mut browser = Browser::start(folder().join("axes"));
    let [one, two] = [1, 2].map(|person| browser.open(&play.person(person)));
    browser.wait(&two, "page.environment() === 'plane' && Number.isFinite(page.value('object_2_y', 200))");
    // Of the paper's wave line what is recommended for any network, in the plane of simulated devices.
    browser.evaluate(&one, "page.command('anyway scene any-network axis.count=2 axis.shared=2')");
    browser.wait(
        &one,
        "page.value('restarts', 200) >= 1 && document.getElementById('verdict').textContent.startsWith('stable')",
    );

    // Above: what the hand does along and across, both copies follow along and across. Devices start anew where they are.
    let [x, y] = browser.numbers(&one, "[page.value('object_2'), page.value('object_2_y')]");
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    carry(&mut browser, &one, hand, [30.0, 40.0]);
    let followed = format!("page.value(`object_${{n}}`) > {x} + 0.01 && page.value(`object_${{n}}_y`) > {y} + 0.015");
    browser.wait(&two, &format!("[1, 2].every((n) => {followed})"));
    browser.picture(&one, &folder().join("plane.png"));
    let [apart, said] = browser.numbers(
        &one,
        "[1e3 * Math.hypot(page.value('object_1') - page.value('object_2'), page.value('object_1_y') - page.value('object_2_y')), \
         Number(document.getElementById('true').textContent)]",
    );
    assert!((apart - said).abs() < 0.2 + 0.2 * apart, "{apart} {said}");
    browser.mouse(&one, "mouseReleased", hand);

    // In space the second picture has the third axis; Page Up lifts as well.
    set(&mut browser, &one, "environment", "space");
    for window in [&one, &two] {
        browser.wait(window, "page.environment() === 'space' && Math.abs(page.value('object_2_z', 200)) < 1e-3");
    }
    let [x, y] = browser.numbers(
        &one,
        "[scene.getScreenCTM().e + scene.getScreenCTM().a * (352 - 38 + 1e3 * page.value('device_1')), \
         scene.getScreenCTM().f - scene.getScreenCTM().d * 1e3 * page.value('device_1_z')]",
    );
    browser.mouse(&one, "mousePressed", [x, y]);
    carry(&mut browser, &one, [x, y], [0.0, 40.0]);
    browser.wait(&two, "page.value('object_2_z') > 0.015 && Math.abs(page.value('object_2_y')) < 2e-3");
    browser.picture(&one, &folder().join("space.png"));
    browser.mouse(&one, "mouseReleased", [x, y]);
    browser.evaluate(&one, "document.getElementById('hand').focus()");
    for _ in 0..20 {
        browser.evaluate(
            &one,
            "document.getElementById('hand').dispatchEvent(new KeyboardEvent('keydown', { key: 'PageDown', shiftKey: true }))",
        );
    }
    browser.wait(&two, "page.value('object_2_z') < -0.02");
    let csv = browser.evaluate(&one, "page.asCsv().split('\\n')[0]");
    let head = csv.as_str().unwrap_or_default();
    assert!(head.ends_with(",push_1_z_n,push_2_z_n") && head.matches("restarts").count() == 1, "{csv}");

    // Settings decide, too, whoever gives them.
    browser.evaluate(&one, "page.command('anyway set axis.count=1 axis.shared=1')");
    browser.wait(
        &two,
        "page.environment() === 'pair' && getComputedStyle(document.getElementById('pair')).display !== 'none'",
    );
    let complaints = browser.complaints(&[&one, &two]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// One button shows three laws on one bad network: the self-timed one holds where power tears, and says so. A lane that came apart says so
/// until all begin again, also in a window that is opened later. Each packet is drawn. A hand takes all lanes. Controls can be pressed with a thumb, and nothing is wider than a phone.
#[test]
fn three_laws_on_a_bad_network() {
    let play = Play::start(&[]);
    let mut browser = Browser::start(folder().join("laws"));
    let one = browser.open(&play.person(1));
    browser.wait(&one, "page.environment() === 'pair' && page.value('device_1', 200) === 0");
    let size = |width: u32, height: u32| json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
    browser.call(&one, "Emulation.setDeviceMetricsOverride", size(1440, 900));
    click(&mut browser, &one, "to-bad-network");
    browser.wait(&one, "page.environment() === 'bad-network' && document.getElementById('lanes-loss').value === '30'");
    browser.wait(&one, "document.querySelector('#lane-timed.holds')");
    browser.picture(&one, &folder().join("laws-begin.png"));
    let [torn, holds] =
        ["#lane-power.torn .state", "#lane-timed.holds .state"].map(|of| format!("document.querySelector('{of}')"));
    browser
        .wait(&one, &format!("/^✗ came apart: .* mm at most, \\d+ s ago\\. Now .* mm\\.$/.test({torn}?.textContent)"));
    browser.wait(
        &one,
        &format!("/^✓ held together for all \\d+ s since the start: .* mm at most$/.test({holds}?.textContent)"),
    );
    browser.wait(&one, "/^power came apart, .*, self-timed held$/.test(document.getElementById('status').textContent)");
    // What is said of a lane is said in its colour, and of no lane in that of another state.
    let colours =
        browser.evaluate(&one, &format!("getComputedStyle({torn}).color !== getComputedStyle({holds}).color"));
    assert_eq!(colours, true);
    let [sent, power, timed] = browser.numbers(
        &one,
        "[page.value('sent_timed'), page.value('fault_power') ? NaN : page.value('lost_power'), page.value('lost_timed')].map((n) => n || 0)",
    );
    assert!(sent > 0.0 && (power == 0.0 || power == timed), "{sent} {power} {timed}");
    browser.wait(&one, "document.querySelector('#lane-power.torn') && page.value('lasted_timed') > 8");
    browser.picture(&one, &folder().join("laws.png"));

    // As many marks as packets in these two seconds, and as many short ones as were lost: asked right after a frame was drawn, before more comes.
    let [drawn, missing, sent, lost] = browser.numbers(
        &one,
        "new Promise((done) => requestAnimationFrame(() => done([ \
         ...['.came', '.lost'].map((of) => document.querySelector(`.packets ${of}`).getAttribute('d').split('M').length - 1), \
         ...['sent', 'lost'].map((of) => page.value(`${of}_timed`) - page.value(`${of}_timed`, 2000))])))",
    );
    assert!((sent - 500.0).abs() <= 2.0, "{sent}");
    assert_eq!([drawn + missing, missing], [sent, lost]);

    // Without losses the copies of power come together again, and what was is still said, in a window that saw nothing of it as well.
    set(&mut browser, &one, "lanes-loss", "0");
    let near = "Math.max(...Array.from({ length: 1500 }, (_, ago) => Math.abs(page.value('object_1_power', ago) - page.value('object_2_power', ago)))) < 0.009";
    browser.wait(&one, near);
    let late = browser.open(&play.person(2));
    browser.wait(&late, &format!("{near} && document.querySelector('#lane-power .state').textContent.length > 5"));
    for window in [&one, &late] {
        let [said, worst] = browser.numbers(
            window,
            "[parseFloat(document.querySelector('#lane-power.torn .state').textContent.split('came apart: ')[1]), 1e3 * page.value('worst_power')]",
        );
        assert!(worst > 10.0 && (said - worst).abs() < 1.0, "{said} {worst}");
        browser.wait(window, "document.querySelector('#status.bad').textContent.startsWith('power came apart, ')");
    }
    browser.call(&late, "Page.close", json!({}));
    set(&mut browser, &one, "lanes-loss", "30");

    // A finger's hand in any lane is one in all of them.
    click(&mut browser, &one, "again");
    browser.wait(&one, "page.value('restarts') === 1 && page.value('lasted_timed') < 5");
    let at = browser.numbers(
        &one,
        "(() => { const r = document.querySelector('#lane-wave svg').getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2, \
         document.querySelector('#lane-wave svg').getScreenCTM().a]; })()",
    );
    let [x, y, per_mm]: [f64; 3] = at;
    browser.mouse(&one, "mousePressed", [x, y]);
    for step in 0..=40 {
        browser.mouse(&one, "mouseMoved", [x + per_mm * f64::from(step), y]);
        std::thread::sleep(std::time::Duration::from_millis(16));
    }
    browser.wait(
        &one,
        "page.value('wanted_1') > 0.03 && page.value('device_1_timed') > 0.02 && page.value('device_2_timed') > 0.02",
    );
    browser.mouse(&one, "mouseReleased", [x, y]);
    browser.wait(&one, "Number.isNaN(page.value('wanted_1'))");

    // Without losses all three hold.
    set(&mut browser, &one, "lanes-loss", "0");
    browser.wait(&one, "page.value('lost_timed') === page.value('lost_timed', 500)");
    click(&mut browser, &one, "again");
    browser.wait(&one, "page.value('lasted_timed', 1000) > 3 && document.querySelectorAll('.lane.holds').length === 3");
    browser.wait(&one, "!document.getElementById('status').classList.contains('bad')");

    // On a phone.
    browser.call(&one, "Emulation.setDeviceMetricsOverride", size(390, 844));
    set(&mut browser, &one, "lanes-loss", "30");
    browser.wait(&one, "document.querySelector('#lane-power.torn')");
    let [wide, low, small] = browser.numbers(
        &one,
        "[document.documentElement.scrollWidth, \
         Math.min(...[...document.querySelectorAll('button, select, input')].map((e) => e.getBoundingClientRect().height).filter((h) => h > 0)), \
         Math.min(...[...document.querySelectorAll('p, h1, h2, dt, dd, label, figcaption, span')].map((e) => parseFloat(getComputedStyle(e).fontSize)))]",
    );
    assert!(wide <= 390.0 && low >= 43.9 && small >= 12.0, "{wide} {low} {small}");
    browser.picture(&one, &folder().join("laws-phone.png"));
    click(&mut browser, &one, "to-workshop");
    browser.wait(
        &one,
        "page.environment() === 'pair' && getComputedStyle(document.getElementById('scene')).display !== 'none'",
    );
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
