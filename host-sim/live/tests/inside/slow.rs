//! A device that is asked in plain calls: how often, what it is given, and what becomes of one that fails or does not come back.

use std::sync::{Arc, Mutex};

use cohold_sim::device::DeviceFault;

use super::super::Port;
use super::*;

/// What was done with a device, and what it does.
#[derive(Default)]
struct Done {
    reads: u32,
    forces: Vec<Row>,
    fails: bool,
    hangs: Duration,
}

struct Handle(Arc<Mutex<Done>>);

impl Asked for Handle {
    fn read(&mut self) -> Result<(Row, Option<Row>), String> {
        let mut done = self.0.lock().unwrap();
        done.reads += 1;
        let (place_m, hangs) = (0.001 * f64::from(done.reads), done.hangs);
        if done.fails {
            return Err("its cable is out".to_owned());
        }
        drop(done);
        std::thread::sleep(hangs);
        Ok(([place_m, 0.0, 0.0], None))
    }

    fn write(&mut self, force_n: Row) -> Result<(), String> {
        self.0.lock().unwrap().forces.push(force_n);
        Ok(())
    }
}

fn opened() -> (Threaded, Arc<Mutex<Done>>) {
    let done = Arc::new(Mutex::new(Done::default()));
    let abilities = Abilities { name: "a handle".to_owned(), axes: 1, ..Abilities::default() };
    (open(abilities, Duration::from_millis(50), Handle(done.clone())).expect("a thread"), done)
}

/// Drives it at 1 kHz; the newest that it told.
fn drive(port: &mut Threaded, ticks: u32, force_n: f64) -> Result<Option<Sensed>, Gone> {
    for _ in 0..ticks {
        port.write(Some([force_n, 0.0, 0.0]));
        std::thread::sleep(Duration::from_millis(1));
    }
    port.read()
}

#[test]
fn it_is_asked_200_times_a_second_at_most_and_its_speed_is_reckoned() {
    let (mut port, done) = opened();
    let start = Instant::now();
    let sensed = drive(&mut port, 300, 1.5).expect("a device that answers").expect("a reading");
    let most = (start.elapsed().as_secs_f64() * MOST_HZ).ceil() as u32 + 1;
    let reads = done.lock().unwrap().reads;
    // A busy machine asks it less often.
    assert!((most / 4..=most).contains(&reads), "{reads} of {most}");
    let speed = sensed.velocity_m_per_s[0];
    // A millimetre a reading, and a reading every 5 ms or more.
    assert!(speed > 0.0 && speed <= 0.21, "{speed}");
    assert_eq!(done.lock().unwrap().forces.last(), Some(&[1.5, 0.0, 0.0]));
    drop(port);
    assert_eq!(done.lock().unwrap().forces.last(), Some(&Row::default()), "whoever is dropped lets go first");
}

#[test]
fn one_that_fails_is_stopped_and_let_go_of() {
    let (mut port, done) = opened();
    drive(&mut port, 20, 1.0).expect("a device that answers");
    done.lock().unwrap().fails = true;
    let gone = drive(&mut port, 30, 1.0).expect_err("a device that has failed");
    assert_eq!((gone.fault, gone.cause.as_str()), (DeviceFault::Stopped, "its cable is out"));
    assert_eq!(done.lock().unwrap().forces.last(), Some(&Row::default()));
}

#[test]
fn one_that_does_not_come_back_holds_nobody_up() {
    let (mut port, done) = opened();
    drive(&mut port, 20, 1.0).expect("a device that answers");
    done.lock().unwrap().hangs = Duration::from_secs(3);
    let told = drive(&mut port, 100, 1.0).expect("nothing new").expect("a reading");
    assert!(told.between[0].elapsed() > Duration::from_millis(60), "old readings are said to be old");
    let start = Instant::now();
    drop(port);
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
}
