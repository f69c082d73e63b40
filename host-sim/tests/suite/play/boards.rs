//! The page as the operator of two simulated boards: what turns motors on is confirmed, Stop is always there, a closed page lets go.

use super::{Browser, Play, click, folder, press};

#[test]
fn two_boards_are_commanded_from_a_page() {
    let play = Play::start(&["--board", "simulated"]);
    let mut browser = Browser::start(folder().join("boards"));
    let one = browser.open(&play.addresses[0]);
    let status = "document.getElementById('status').textContent";
    browser.wait(&one, &format!("{status} === 'all motors are off'"));
    assert_eq!(browser.evaluate(&one, "getComputedStyle(document.getElementById('controls')).display"), "none");

    // A check, and what it found.
    browser.evaluate(
        &one,
        "[...document.querySelectorAll('#board2 button')].find((b) => b.textContent.startsWith('Check joint 1')).click()",
    );
    browser.wait(&one, "document.querySelector('#board2 .said').textContent.includes('motor and encoder agree')");
    browser.picture(&one, &folder().join("boards.png"));

    // Armed only when that was confirmed.
    press(&mut browser, &one, "Arm board 2");
    browser.wait(&one, "!document.getElementById('question').hidden");
    browser.picture(&one, &folder().join("boards-asks.png"));
    click(&mut browser, &one, "leave");
    browser.wait(&one, "document.getElementById('question').hidden");
    assert_eq!(browser.evaluate(&one, status), "all motors are off");
    press(&mut browser, &one, "Arm board 2");
    click(&mut browser, &one, "anyway");
    browser.wait(&one, &format!("{status}.startsWith('the motors of board 2 are on')"));
    click(&mut browser, &one, "stop");
    browser.wait(&one, &format!("{status} === 'all motors are off'"));

    // A line of another making is none.
    browser.evaluate(&one, "page.command('board 1 set safety.max_force_n 40')");
    browser.wait(&one, "document.getElementById('refused').textContent.includes('board operator')");

    // Who only watches sees the same and commands nothing; a window that is gone has let go.
    let watching = browser.open(&play.addresses[1]);
    browser.wait(&watching, "document.querySelectorAll('#boards button').length === 8");
    let buttons = "[...document.querySelectorAll('#boards button, #stop, #start')]";
    assert_eq!(browser.evaluate(&watching, &format!("{buttons}.every((b) => b.disabled)")), true);
    browser.evaluate(&watching, "page.command('board 1 arm')");
    browser.wait(&watching, "document.getElementById('refused').textContent.startsWith('only the operator')");
    // With another role before its key, its address opens nothing.
    let changed = browser.open(&play.addresses[1]);
    let (host, ring) = play.addresses[1].split_once("/#watch-").expect("an address");
    for role in ["operator", "hand1", "hand2"] {
        let outcome = browser.evaluate(
            &changed,
            &format!(
                "new Promise((done) => {{ const s = new WebSocket('{}/ws/{role}-{ring}'); s.onopen = () => done('open'); \
                 s.onerror = () => done('refused'); }})",
                host.replace("http", "ws")
            ),
        );
        assert_eq!(outcome, "refused", "{role}");
    }
    press(&mut browser, &one, "Arm board 2");
    click(&mut browser, &one, "anyway");
    browser.wait(&watching, &format!("{status}.startsWith('the motors of board 2 are on')"));
    browser.call(&one, "Page.navigate", serde_json::json!({ "url": "about:blank" }));
    browser.wait(&watching, &format!("{status} === 'all motors are off'"));
    let complaints = browser.complaints(&[&one, &watching]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
