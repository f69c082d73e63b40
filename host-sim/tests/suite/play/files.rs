//! What leaves a page and comes back: pictures and numbers of what is shown, scene files, and links from one run to another.

use std::path::Path;

use super::{Browser, Play, Window, click, folder, press, set};

/// Clicks a button and gives the file that comes of it. A browser keeps its name with an empty file, over which it moves the whole one.
fn saved(browser: &mut Browser, window: &Window, folder: &Path, button: &str, name: &str) -> Vec<u8> {
    let file = folder.join(name);
    click(browser, window, button);
    let start = std::time::Instant::now();
    while std::fs::metadata(&file).map_or(0, |file| file.len()) == 0 {
        assert!(start.elapsed().as_secs() < 30, "{name} was not saved");
        std::thread::sleep(std::time::Duration::from_millis(30));
    }
    std::fs::read(file).expect("a file")
}

#[test]
fn what_is_seen_is_saved() {
    let play = Play::start(&["--partner", "carries-on"]);
    let downloads = folder().join("downloads");
    let _ = std::fs::remove_dir_all(&downloads);
    std::fs::create_dir_all(&downloads).expect("a folder");
    let mut browser = Browser::start(folder().join("files"));
    let one = browser.open(&play.addresses[0]);
    browser.downloads(&downloads);
    browser.wait(&one, "Number.isFinite(page.value('device_1', 3000))");
    click(&mut browser, &one, "pause");

    // Every column, every tick of what is shown, the time in even steps.
    let csv = String::from_utf8(saved(&mut browser, &one, &downloads, "csv", "play.csv")).expect("text");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].len(), 25, "{:?}", rows[0]);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()) && rows.len() > 2500, "{} rows", rows.len());
    let time = |row: &[&str]| row[0].parse::<f64>().expect("a time");
    assert!(rows[1..].windows(2).all(|pair| (time(&pair[1]) - time(&pair[0]) - 0.001).abs() < 1e-6));

    let svg = String::from_utf8(saved(&mut browser, &one, &downloads, "svg", "play.svg")).expect("text");
    // Ten series, each in a plot and in its legend; what is shown, under which law, when; titles with units, numbers at both axes.
    assert!(svg.starts_with("<svg xmlns") && svg.matches("<path").count() == 20, "{}", svg.len());
    assert!(!svg.contains("NaN") && !svg.contains("undefined"));
    for words in [
        "pair, law self-timed, 8 ms one way",
        " UTC · ",
        "Position, mm",
        "Force, N",
        "Energy, mJ",
        "time since the beginning, s",
    ] {
        assert!(svg.contains(words), "{words}");
    }
    for words in ["copy 1", "copy 2", "as peer 1 believes", "used up by 2"] {
        assert!(svg.contains(&format!(">{words}</text>")), "{words}");
    }
    let labels = |ending: &str| svg.matches(&format!("{ending}</text>")).count();
    // Of each plot the title and the highest number have the unit.
    assert!(labels(" s") >= 4 * 3 && labels(" mm") == 4 && labels(" N") == 2, "{} {}", labels(" mm"), labels(" N"));
    // A signature, then width and height of the picture: the four plots below each other with what stands above them.
    let png = saved(&mut browser, &one, &downloads, "png", "play.png");
    let [wide, high] = [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().expect("four bytes")));
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && wide == 1840 && high > 1000, "{wide} {high}");
    let toml = String::from_utf8(saved(&mut browser, &one, &downloads, "save", "scene.toml")).expect("text");
    assert!(toml.contains("[coordination]") && toml.parse::<toml::Table>().is_ok(), "{toml}");
    let complaints = browser.complaints(&[&one]);
    assert!(complaints.is_empty(), "{complaints:?}");
}

#[test]
fn a_link_carries_a_scene_to_another_run() {
    let [here, there] =
        [&["--scene", "any-network"], &["--scene", "matched-line"]].map(|arguments| Play::start(arguments));
    let mut browser = Browser::start(folder().join("links"));
    let one = browser.open(&here.addresses[0]);
    browser.wait(&one, "document.getElementById('verdict').textContent.startsWith('stable')");
    set(&mut browser, &one, "delay", "60");
    set(&mut browser, &one, "loss", "20");
    browser.wait(&one, "page.asLink().includes('0.06') && page.asLink().includes('loss%3D0.2')");
    let link = browser.evaluate(&one, "page.asLink()").as_str().expect("a link").to_owned();
    let (_, ring) = here.addresses[0].split_once('#').expect("an address");
    let mut keys = ring.split('+').filter_map(|key| key.split_once('-'));
    assert!(keys.all(|(role, key)| !link.contains(key) && !link.contains(role)), "a link gives nobody a key: {link}");

    // In a window of the other run everything is as it was here.
    let other = browser.open(&there.addresses[0]);
    browser.wait(&other, "document.getElementById('verdict').textContent.startsWith('stable')");
    assert_ne!(browser.evaluate(&other, "document.getElementById('loss').value"), "20");
    set(&mut browser, &other, "paste", &link);
    press(&mut browser, &other, "Open link");
    browser.wait(&other, "document.getElementById('loss').value === '20'");
    let (path, tail) = link.split_once('#').expect("a part behind #");
    assert!(path.starts_with("http://127.0.0.1:"));
    assert_eq!(browser.evaluate(&other, "page.asLink().split('#')[1]"), tail);

    // Behind the address of a run it is opened with it.
    let another = browser.open(&format!("{}{tail}", there.addresses[3]));
    browser.wait(&another, "document.getElementById('delay').value === '60'");

    // What is unstable asks first, wherever it comes from, and no link can say that it need not.
    let unstable = "scene paper-5.2-passive-wave-16ms coordination.comm=power coordination.stiffness_n_per_m=3000";
    for (order, asks) in [(unstable, true), (&format!("anyway {unstable}"), false), ("stop", false)] {
        let link = format!("http://127.0.0.1:1/#/{}", order.replace(' ', "%20"));
        set(&mut browser, &other, "paste", &link);
        press(&mut browser, &other, "Open link");
        if asks {
            browser.wait(&other, "!document.getElementById('question').hidden");
            click(&mut browser, &other, "leave");
        } else {
            browser.wait(&other, "document.getElementById('refused').textContent === 'this link carries no scene'");
        }
    }
    assert_eq!(browser.evaluate(&other, "document.getElementById('loss').value"), "20");
    let named = browser.open(&link);
    browser.wait(&named, "document.getElementById('status').textContent.startsWith('this address names no run')");
    let complaints = browser.complaints(&[&one, &other, &another, &named]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
