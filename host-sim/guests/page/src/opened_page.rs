//! The page of a recording: served as the live page is, to whoever has its address, and given any part of the recording that it asks for.
//!
//! | from a window | |
//! |---|---|
//! | 8 bytes | first tick that is wanted, and how many from there, each u32; little-endian |
//!
//! | to a window | |
//! |---|---|
//! | `{"hello"}` | as of a live page, with `recording`: whose it is, how long, and how far the copies were apart in each part of it |
//! | `{"holds"}` | the scene that made it, where that is known |
//! | bytes | a header as of a live page, in which tick and environment stand, and samples: never more than [`opened::MOST_ASKED`](super::opened) ticks |

use std::io::ErrorKind;
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use cohold_live::endpoint::Stop;
use cohold_sim::Laws;
use cohold_sim::scene::Scene;
use serde_json::{Value, json};
use tungstenite::{Error as Line, Message, WebSocket};

use super::doors::Doors;
use super::judge;
use super::kinds::Kinds;
use super::mailbox::Mailbox;
use super::opened::Opened;
use super::orders;
use super::partner::Model;
use super::roles::Role;
use super::web::{self, Site, hello};
use cohold_cli::Failure;

/// How often it is looked whether the program is to end.
const LOOK: Duration = Duration::from_millis(50);

/// A page of a recording that is served.
pub(crate) struct OpenedPage {
    site: Site,
    mailbox: Arc<Mailbox>,
}

impl OpenedPage {
    /// Serves it on 127.0.0.1, at any port where `port` is 0.
    pub(crate) fn serve(opened: Opened, kinds: Kinds, laws: Laws, port: u16) -> Result<Self, Failure> {
        let (doors, listeners) = Doors::open(port, None)?;
        let scene = orders::of_file(laws, &opened.scene).ok();
        let mut greeting = hello(kinds, scene.as_ref().unwrap_or(&Scene::new(laws)), None, false);
        greeting["recording"] = opened.hello();
        greeting["period_s"] = json!(opened.period_s());
        let holds = scene.map(|scene| judge::holds(&scene, None, None));
        let mailbox = Arc::new(Mailbox::new(Model::default()));
        let site = Site::new(doors, greeting)?.of_recording(opened, holds);
        // Nobody orders anything here.
        site.serve(listeners, &mailbox, sync_channel(1).0)?;
        Ok(Self { site, mailbox })
    }

    /// The address of the page.
    pub(crate) fn address(&self) -> String {
        self.site.address(&[Role::Watch])
    }

    /// Serves until it is asked to stop, or so many seconds are over.
    pub(crate) fn run(self, seconds: f64, stop: &Stop) {
        let begun = Instant::now();
        while !stop.is_asked() && begun.elapsed().as_secs_f64() < seconds {
            std::thread::sleep(LOOK);
        }
        self.mailbox.lock().over = true;
        // Windows look four times a second: each sees that it is over, and closes.
        std::thread::sleep(Duration::from_millis(300));
    }
}

/// One window, until it goes or the program ends.
pub(super) fn window(
    mut socket: WebSocket<TcpStream>,
    hello: &Value,
    (opened, holds): &(Opened, Option<String>),
    mailbox: &Mailbox,
) {
    let greeting = json!({ "hello": hello }).to_string();
    let first = std::iter::once(&greeting).chain(holds);
    if first.map(|text| socket.send(Message::text(text))).all(|sent| sent.is_ok()) {
        answer(&mut socket, opened, mailbox);
    }
    web::hang_up(&mut socket, mailbox.lock().over.then_some(web::OVER));
}

fn answer(socket: &mut WebSocket<TcpStream>, opened: &Opened, mailbox: &Mailbox) {
    while !mailbox.lock().over {
        match socket.read() {
            Ok(Message::Binary(bytes)) => {
                let Ok([a, b, c, d, e, f, g, h]) = <[u8; 8]>::try_from(&bytes[..]) else { return };
                let [from, count] = [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes);
                let mut part = web::header_of(from, opened.kind()).to_vec();
                part.extend(opened.samples(from, count).flat_map(|number| number.to_le_bytes()));
                if socket.send(Message::Binary(part.into())).is_err() {
                    return;
                }
            }
            Ok(Message::Close(_)) => return,
            Ok(_) => {}
            Err(Line::Io(error)) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(_) => return,
        }
    }
}
