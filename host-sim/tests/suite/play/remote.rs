//! Two machines, here two processes: each has its own page and its own hand, over the sealed link.

use super::{Browser, Play, click, drag, folder, middle};
use crate::program::{Keys, free};

#[test]
fn two_machines_hold_one_object() {
    let (keys, at) = (Keys::new("play-far", 0), free());
    let here = Play::start(&["--listen", &at, "--key-file", &keys.file(0)]);
    let mut browser = Browser::start(folder().join("far"));
    let one = browser.open(&here.addresses[0]);
    let status = "document.getElementById('status').textContent";
    browser.wait(&one, &format!("{status}.startsWith('waiting for peer 2, which joins at')"));
    let there = Play::start(&["--join", &at, "--key-file", &keys.file(0)]);
    let two = browser.open(&there.addresses[0]);
    for (window, other) in [(&one, "peer 2, which joins"), (&two, "peer 1 at")] {
        browser.wait(window, &format!("{status}.startsWith('{other}') && {status}.endsWith('has the other hand')"));
        // What is the same at both ends is not changed at one.
        let set = "['environment', 'delay', 'mass', 'law', 'stiffness', 'save'].filter((id) => document.getElementById(id).offsetParent).join()";
        assert_eq!(browser.evaluate(window, set), "save");
    }
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    let at = drag(&mut browser, &one, hand, 40.0);
    browser.wait(&two, "page.value('object_2') > 0.03 && page.value('object_1') > 0.03");
    browser.wait(&one, "Math.abs(page.value('object_2') - page.value('object_1')) < 0.005");
    browser.picture(&two, &folder().join("far.png"));
    browser.mouse(&one, "mouseReleased", at);

    // Stop at one end turns off its own motors and no others, and both say so; nothing but a start there takes it back.
    let says = |words: &str| format!("{status} === '{words}'");
    click(&mut browser, &one, "stop");
    browser.wait(&one, &says("stopped: your motors are off. Press Start. the motors of peer 2 are on"));
    browser.wait(&two, &says("the motors of peer 1 are off, yours are on. Press Stop to turn yours off."));
    click(&mut browser, &two, "stop");
    for window in [&one, &two] {
        browser.wait(window, &says("stopped: motors are off. Press Start."));
    }
    for window in [&one, &two] {
        click(&mut browser, window, "start");
    }
    browser.wait(&two, &format!("{status}.endsWith('has the other hand')"));
    click(&mut browser, &two, "stop");
    browser.wait(&two, &says("stopped: your motors are off. Press Start. the motors of peer 1 are on"));
    drop(here);
    browser
        .wait(&two, &format!("{status}.startsWith('stopped: your motors are off. Press Start. waiting for peer 1')"));
    let complaints = browser.complaints(&[&two]);
    assert!(complaints.is_empty(), "{complaints:?}");

    // A Stop that nobody receives says so, and what to press.
    drop(there);
    browser.wait(&two, &format!("{status}.startsWith('no answer from the program')"));
    click(&mut browser, &two, "stop");
    browser.wait(&two, &format!("{status}.startsWith('Stop was not sent: press the stop at the board or device. ')"));
}
