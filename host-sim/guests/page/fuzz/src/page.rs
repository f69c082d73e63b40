//! Any bytes as what a stranger or a page's window sends to the live page's web server: the head of a request, questions of 20 bytes, and
//! messages of text, which end at bytes of zero. Behind an empty message, and at the end, ticks pass, with the control loop's own
//! exchange. Two bytes of which the first is none of UTF-8's are one of the [`words`] that there are, so that the fuzzer need not spell.
//!
//! - A window opens only for `GET /ws/RING`, every key of which is that of its role, from a page of ours at the host of its way in, and by
//!   the local network for nobody who operates. The fuzzer
//!   knows no key: where it writes `KEY`, the key of role number 0 to 3 is put in for the digit behind.
//! - A question gives a finite place within reach, or lets go.
//! - An order gives a scene that can be written down, written back and shown, and that reads no file; or one line of bounded length
//!   says why not. No order, nor any row of them between two ticks, ends the control loop, or has it show what the judge did not allow.
//!
//! What the judge computes of a scene is left out: it takes as long as it takes.

use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::OnceLock;

use cohold_core::settings::{Allowed, Key};
use cohold_sim::{Laws, scene::Scene, scenes};
use serde_json::Value;
use tungstenite::Message;

use super::control_loop::{Shown, exchange};
use super::doors::{Doors, Way};
use super::environment::Sample;
use super::judge::{LONGEST_REFUSAL, refusal, wanted};
use super::kinds::{EnvironmentKind, Kinds};
use super::mailbox::{Mailbox, Request};
use super::messages::{FARTHEST_M, command, question};
use super::orders;
use super::partner::Model;
use super::roles::Role;
use super::web::{Answer, FILES, LONGEST_MESSAGE, Site, head, next, picture};

/// Port of the site on this machine, and where it is on the local network.
const PORT: u16 = 7000;
const LAN: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(192, 168, 7, 1), 7001);
/// Messages and questions of an input that count: more take time, and reach nothing else.
const MOST: usize = 16;
/// The bytes from here on are none of UTF-8's.
const FIRST_OF_A_WORD: u8 = 0xf8;
/// Ticks that pass at a time: what was asked for is taken in the first.
const TICKS: usize = 3;

/// Runs one fuzz input.
pub fn run(bytes: &[u8]) {
    heads(bytes);
    let mut page = Open::new();
    page.questions.extend(bytes.chunks(20).take(MOST).map(|chunk| {
        let mut bytes = [0; 20];
        bytes[..chunk.len()].copy_from_slice(chunk);
        bytes
    }));
    for line in text(bytes).split('\0').take(MOST).filter(|line| line.len() <= LONGEST_MESSAGE) {
        if line.is_empty() {
            page.tick();
        } else {
            page.order(line);
        }
    }
    page.tick();
}

/// The bytes as text, with the words that they stand for.
fn text(bytes: &[u8]) -> String {
    let mut spelled = Vec::new();
    let mut bytes = bytes.iter().copied();
    while let Some(byte) = bytes.next() {
        if byte < FIRST_OF_A_WORD {
            spelled.push(byte);
            continue;
        }
        let number = usize::from(byte - FIRST_OF_A_WORD) << 8 | usize::from(bytes.next().unwrap_or_default());
        spelled.extend_from_slice(words()[number % words().len()].as_bytes());
    }
    String::from_utf8_lossy(&spelled).into_owned()
}

/// Every key with the ends of its range or with its names, and every order with what it names.
fn words() -> &'static [String] {
    static WORDS: OnceLock<Vec<String>> = OnceLock::new();
    WORDS.get_or_init(|| {
        let scene = Scene::new(Laws::built_in());
        let laws = || scene.laws.all().iter().map(|law| law.name);
        let key = |(name, key): (String, Key)| {
            let values: Vec<String> = match key.allowed {
                Allowed::Number { min, max } => vec![min.to_string(), max.to_string()],
                Allowed::Whole { min, max } => vec![min.to_string(), max.to_string()],
                Allowed::Names(names) => names.iter().map(|name| (*name).to_owned()).collect(),
                Allowed::Laws(_) => laws().map(str::to_owned).collect(),
                _ => vec!["true".to_owned(), "false".to_owned()],
            };
            values.into_iter().map(move |value| format!(" {name}={value}")).collect::<Vec<_>>()
        };
        let shows = Kinds::default().names().into_iter().map(|name| format!("\0show {name}\0"));
        let scenes = scenes::known().map(|(name, _)| format!("\0scene {name}"));
        let orders = laws().map(|name| format!("\0law {name}")).chain(scenes).chain(shows);
        let others = ["\0set", " peer.1.", " peer.2."].map(str::to_owned);
        scene.keys().into_iter().flat_map(key).chain(orders).chain(others).collect()
    })
}

/// The bytes as a request, without any key of this run and with keys: whether these open a window.
fn heads(bytes: &[u8]) -> bool {
    static SITE: OnceLock<(Site, [String; 4])> = OnceLock::new();
    let (site, rings) = SITE.get_or_init(|| {
        let site = Site::new(Doors { here: PORT, lan: Some(LAN) }, Value::Null).expect("randomness");
        let roles = [Role::Hand1, Role::Hand2, Role::Operator, Role::Watch];
        let ring = |role| site.address(&[role]).split_once('#').expect("an address").1.to_owned();
        let rings = roles.map(ring);
        (site, rings)
    });
    let opens = |bytes: &[u8]| [Way::Here, Way::Lan].map(|way| opens(site, way, bytes, rings)).contains(&true);
    assert!(!opens(bytes), "a window without a key");
    let mut known = bytes.to_vec();
    for (digit, ring) in (b'0'..).zip(rings) {
        let key = ring.split_once('-').expect("a role and its key").1;
        while let Some(at) = known.windows(4).position(|four| four == [b'K', b'E', b'Y', digit]) {
            known.splice(at..at + 4, key.bytes());
        }
    }
    opens(&known)
}

/// Whether this opens a window; what opens one or gets a file is ours by what stands in its lines.
fn opens(site: &Site, way: Way, sent: &[u8], rings: &[String; 4]) -> bool {
    let Ok(Some((head, rest))) = head(&mut &*sent) else { return false };
    assert!(head.ends_with(b"\r\n\r\n") && sent.starts_with(&[&head[..], &rest].concat()));
    let answer = site.answer(way, &head);
    if let Answer::Refused(status) = &answer {
        assert!(status.starts_with('4'), "{status}");
        return false;
    }
    let text = String::from_utf8_lossy(&head);
    let mut lines = text.trim_start_matches(['\r', '\n']).lines();
    let asked: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
    let lines: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    // The one value of a name.
    let value = |name: &str| {
        let named = lines.iter().filter_map(|line| line.split_once(':'));
        let values: Vec<&str> =
            named.filter(|(of, _)| of.eq_ignore_ascii_case(name)).map(|(_, value)| value.trim()).collect();
        if let [value] = values[..] { value } else { panic!("{name} is {values:?} in {text}") }
    };
    let host = value("host");
    let hosts: &[&str] = if way == Way::Here { &["127.0.0.1:7000", "localhost:7000"] } else { &["192.168.7.1:7001"] };
    assert!(hosts.contains(&host), "{text}");
    let [method, path, _] = asked[..] else { panic!("{asked:?}") };
    assert_eq!(method, "GET");
    match answer {
        Answer::Window(rights, accept) => {
            assert_eq!(value("origin"), format!("http://{host}"));
            let keys: Vec<&str> = path.strip_prefix("/ws/").expect("where windows connect").split('+').collect();
            let opened: Vec<bool> = rings.iter().map(|ring| keys.contains(&ring.as_str())).collect();
            assert!(keys.iter().all(|key| rings.iter().any(|ring| ring == key)), "{path}");
            assert_eq!(rights.hand, opened[..2].iter().position(|hand| *hand));
            assert!(!(opened[0] && opened[1]) && rights.operates == opened[2]);
            assert!(way == Way::Here || !rights.operates, "{text}");
            assert_eq!(accept.len(), 28);
            true
        }
        Answer::File(..) => {
            assert!(FILES.iter().any(|(name, ..)| *name == path), "{path}");
            false
        }
        Answer::Refused(_) => false,
    }
}

/// A page that is open, with a window at each hand.
struct Open {
    mailbox: Mailbox,
    shown: Shown,
    waiting: VecDeque<Sample>,
    /// What the judge goes by.
    scene: Scene,
    kind: EnvironmentKind,
    questions: VecDeque<[u8; 20]>,
}

impl Open {
    fn new() -> Self {
        let (scene, kind) = (Scene::new(Laws::built_in()), EnvironmentKind::default());
        let shown = Shown { environment: kind.open(&scene).expect("the scene of no file"), kind };
        let mailbox = Mailbox::new(Model::default());
        mailbox.lock().holder = [Some(1); 2];
        Self { mailbox, shown, waiting: VecDeque::new(), scene, kind, questions: VecDeque::new() }
    }

    /// A message of the operator's: whether it is taken.
    fn order(&mut self, line: &str) -> bool {
        if let Some(command) = command(line) {
            self.mailbox.lock().ask(command);
            return true;
        }
        match wanted(&self.scene, self.kind, line.strip_prefix("anyway ").unwrap_or(line), Kinds::default(), None) {
            Ok(Request::Scene(scene)) => {
                self.mailbox.lock().want(Request::Scene(scene.clone()));
                (self.kind, self.scene) = (self.kind.in_scene(&scene), *scene);
            }
            Ok(Request::Show(kind, scene)) => {
                self.mailbox.lock().want(Request::Show(kind, scene.clone()));
                (self.kind, self.scene) = (kind, *scene);
            }
            Err(why) => {
                let why = refusal(&why);
                assert!(why.chars().count() <= LONGEST_REFUSAL && !why.is_empty(), "{why}");
                assert!(!why.chars().any(|character| character.is_control() && character != '\t'), "{why:?}");
                return false;
            }
        }
        self.check(line);
        true
    }

    /// The scene can be shown and said again, and reads no file.
    fn check(&self, line: &str) {
        let scene = &self.scene;
        assert!(scene.check("the scene").is_ok() && orders::check(scene).is_ok(), "{line:?}");
        assert!(scene.network_trace.is_none() && scene.users.iter().all(|user| user.trace.is_none()), "{line:?}");
        let settings = scene.settings();
        let said: Vec<String> = settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let again = orders::apply(&Scene::new(scene.laws), &format!("set {}", said.join(" ")));
        let again = again.unwrap_or_else(|why| panic!("{line:?} gives what cannot be set again: {why}"));
        assert_eq!(again.settings(), settings, "{line:?}");
    }

    /// Windows ask, and ticks pass.
    fn tick(&mut self) {
        for at in 0..2 {
            let (from, pointed) = question(self.questions.pop_front().unwrap_or_default());
            let within = |at: [f32; 3]| at.iter().all(|at| at.is_finite() && at.abs() <= FARTHEST_M);
            assert!(pointed.at.is_none_or(within), "{pointed:?}");
            let mut contents = self.mailbox.lock();
            contents.pointed[at] = Some(pointed);
            let columns = self.shown.kind.columns().len();
            let answers = picture(&mut contents, 1, &mut 0, from);
            let Some(Message::Binary(bytes)) = answers.first() else { panic!("{answers:?}") };
            assert!(
                next(bytes, self.shown.kind).is_some() && (bytes.len() - 20) % (4 * (columns + 1)) == 0,
                "{}",
                bytes.len()
            );
        }
        for _ in 0..TICKS {
            let mut contents = self.mailbox.lock();
            exchange(&mut self.shown, &mut contents, &mut self.waiting, &Default::default())
                .unwrap_or_else(|why| panic!("an order ends the control loop: {why}"));
            let sample = self.shown.environment.step();
            self.waiting.push_back(sample.unwrap_or_else(|why| panic!("an order ends the control loop: {why}")));
        }
        assert_eq!(self.shown.kind, self.kind, "what is shown is not what the judge allowed");
    }
}

#[cfg(test)]
#[path = "../../tests/inside/fuzz.rs"]
mod tests;
