//! The way to two boards on a table, with two virtual ones at its end: the rig behind a pseudo-terminal, the board behind a socket, a probe that
//! takes OpenOCD's words. What runs the list is the same as for a table.

use std::fs::File;
use std::io::{Read, Write};
use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use board_bench::image::Firmware;
use board_bench::pc::operator_key;
use board_bench::reviewed;
use board_bench::rig::openocd::Probe;
use board_bench::rig::table::Table;
use board_bench::rig::{self, Rigged};
use cohold_live::key_file;
use cohold_protocol::key::Role;
use cohold_rig::list::TESTS;
use cohold_rig::run::{self, Boards, Extent};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// What is asked of the probe, and that it was done.
struct Words {
    say: Sender<String>,
    done: Receiver<Result<(), String>>,
}

impl Probe for Words {
    fn begin(&mut self, commands: &str) -> Result<(), String> {
        self.say.send(commands.to_owned()).map_err(|why| why.to_string())
    }

    fn is_done(&mut self) -> Result<bool, String> {
        self.done.try_recv().map_or(Ok(false), |done| done.map(|()| true))
    }
}

/// Carries out what OpenOCD is told of a halt.
fn carry_out(rigged: &mut Rigged, commands: &str) -> Result<(), String> {
    let ms = commands.strip_prefix("halt; sleep ").and_then(|rest| rest.strip_suffix("; resume"));
    rigged.halt(ms.and_then(|ms| ms.parse().ok()).ok_or(format!("the probe does not know `{commands}`"))?)
}

/// Two virtual boards behind the devices of a table, as long as it is kept.
struct Behind {
    board: SocketAddr,
    port: PathBuf,
    over: Arc<AtomicBool>,
    runs: JoinHandle<()>,
}

/// Runs both until it is told to end, no faster than a table does; here once they listen.
fn behind(says: Receiver<String>, done: Sender<Result<(), String>>) -> Behind {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_nonblocking(true).expect("a socket");
    let board = socket.local_addr().expect("an address");
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&master).and_then(|()| unlockpt(&master)).expect("a terminal");
    rustix::fs::fcntl_setfl(&master, OFlags::NONBLOCK).expect("a terminal");
    let port = PathBuf::from(ptsname(&master, Vec::new()).expect("its name").into_string().expect("a name"));
    // Held open, so that it outlives who opens it; and no echo before that.
    let held = File::options().read(true).write(true).open(&port).expect("a terminal");
    let over = Arc::new(AtomicBool::new(false));
    let (ends, (listen, listens)) = (over.clone(), channel());
    let runs = std::thread::spawn(move || {
        let (mut master, _held) = (File::from(master), held);
        let mut rigged = rig::start(Firmware::release()).expect("both take it");
        rigged.pc.carry(socket);
        listen.send(()).expect("somebody waits");
        while !ends.load(Ordering::Relaxed) {
            let begun = Instant::now();
            let mut bytes = [0; 256];
            if let Ok(length) = master.read(&mut bytes) {
                rigged.say(&bytes[..length]);
            }
            if let Ok(commands) = says.try_recv() {
                let outcome = carry_out(&mut rigged, &commands);
                done.send(outcome).expect("somebody waits");
            }
            rigged.run_ms(1);
            master.write_all(&rigged.heard()).expect("a line is short");
            std::thread::sleep(Duration::from_millis(1).saturating_sub(begun.elapsed()));
        }
        rigged.finish().iter().for_each(reviewed::check);
    });
    listens.recv().expect("both start");
    Behind { board, port, over, runs }
}

#[test]
fn the_list_runs_over_a_serial_port_a_socket_and_a_probe() {
    let key = Path::new(env!("CARGO_TARGET_TMPDIR")).join("table-operator.key");
    let _ = std::fs::remove_file(&key);
    key_file::write(&key, Role::Operator, &operator_key()).expect("a file");
    let (say, says) = channel();
    let (done, is_done) = channel();
    let behind = behind(says, done);
    let probe = Box::new(Words { say, done: is_done });
    let mut table = Table::connect(behind.board, &key, &behind.port, probe).expect("both are there");
    run::set_up(&mut table).expect("both take it");
    let test = TESTS.iter().find(|test| test.name == "halt-while-armed").expect("the list has it");
    let outcome = run::run(&mut table, test, Extent::Virtual, None).expect("somebody wrote it down");
    assert!(outcome.is_ok(), "{outcome:?}");
    // Records come over the socket, and the rig's edges are in them.
    let before = table.counts().expect("records come");
    table.order("turn 2 100 up").expect("the port is there");
    assert_eq!(table.answer(5000).as_deref(), Ok("ok"));
    assert_eq!(table.counts().expect("records come"), [before[0], before[1] + 100]);
    behind.over.store(true, Ordering::Relaxed);
    behind.runs.join().expect("it ends well");
}
