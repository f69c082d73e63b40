//! What comes between a port and a peer, with a port whose readings a test writes.

use std::cell::RefCell;
use std::rc::Rc;

use cohold_core::safety::Fault;
use cohold_sim::Laws;

use super::*;

/// What a test tells, and hears of forces.
#[derive(Default)]
struct Told {
    sensed: Option<Sensed>,
    gone: Option<Gone>,
    forces: Vec<Option<[f64; AXES]>>,
}

struct Written {
    abilities: Abilities,
    told: Rc<RefCell<Told>>,
}

impl Port for Written {
    fn abilities(&self) -> &Abilities {
        &self.abilities
    }
    fn read(&mut self) -> Result<Option<Sensed>, Gone> {
        let told = self.told.borrow();
        told.gone.clone().map_or(Ok(told.sensed), Err)
    }
    fn write(&mut self, force_n: Option<[f64; AXES]>) {
        self.told.borrow_mut().forces.push(force_n);
    }
}

fn able() -> Abilities {
    Abilities {
        name: "a handle".to_owned(),
        axes: AXES,
        workspace_m: None,
        max_force_n: None,
        is_homed: true,
        buttons: 1,
        lets_go_s: Some(0.02),
    }
}

fn at(position_m: [f64; AXES], ago: Duration) -> Sensed {
    let when = Instant::now() - ago;
    Sensed { position_m, velocity_m_per_s: [0.1, 0.2, 0.3], between: [when; 2], buttons: 0 }
}

fn scene(settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    Scene::load(Laws::built_in(), None, &settings).expect("a scene")
}

fn attach(
    abilities: Abilities,
    options: &DeviceOptions,
    settings: &[&str],
) -> Result<(Attached<3>, Rc<RefCell<Told>>), Error> {
    // At rest, or it is not armed.
    let first = Sensed { velocity_m_per_s: [0.0; AXES], ..at([0.1, 0.2, 0.3], Duration::ZERO) };
    let told = Rc::new(RefCell::new(Told { sensed: Some(first), ..Told::default() }));
    let port = Box::new(Written { abilities, told: told.clone() });
    Ok((Attached::new(port, options, &scene(settings), 0)?, told))
}

fn pushing(forces: [f32; 3]) -> Actuators<f32, 3> {
    Actuators { forces, enable: true, ..Actuators::default() }
}

#[test]
fn who_may_not_be_armed_is_refused_by_name() {
    let with = |change: &dyn Fn(&mut Abilities)| {
        let mut abilities = able();
        change(&mut abilities);
        attach(abilities, &DeviceOptions::default(), &["axis.count=2"]).err().map(|why| why.to_string())
    };
    assert_eq!(with(&|_| ()), None);
    type Case<'a> = (&'a dyn Fn(&mut Abilities), &'a str);
    let cases: [Case<'_>; 5] = [
        (&|of| of.is_homed = false, "not calibrated"),
        (&|of| of.lets_go_s = None, "how long a handle holds a force"),
        (&|of| of.axes = 1, "has 1 axes"),
        (&|of| of.max_force_n = Some(8.0), "peer.1.safety.max_force_n=8"),
        (&|of| of.workspace_m = Some([0.2; AXES]), "peer.1.safety.workspace_m"),
    ];
    for (change, words) in cases {
        let why = with(change).expect("refused");
        assert!(why.contains("a handle") && why.contains(words), "{why}");
    }
}

/// Axis 1 is the device's −z, and a metre of it is two of the world; forces go back the same way.
#[test]
fn axes_origin_and_scale_go_there_and_back() {
    let options = DeviceOptions { axes: [(2, -1.0), (0, 1.0), (1, 1.0)], ..DeviceOptions::default() };
    let (mut device, told) = attach(able(), &options, &["scale.position=2", "scale.force=4"]).expect("fit");
    // Three millimetres take a hand longer than this test.
    let later = [Instant::now() + Duration::from_millis(20); 2];
    told.borrow_mut().sensed = Some(Sensed { between: later, ..at([0.101, 0.202, 0.297], Duration::ZERO) });
    device.look().expect("there");
    let Reading::Exact(axes) = device.sensors().reading else { panic!("positions") };
    let near = |value: f32, wanted: f64| assert!((f64::from(value) - wanted).abs() < 1e-6, "{value}, not {wanted}");
    for (axis, (position_m, speed)) in axes.into_iter().zip([(0.006, -0.6), (0.002, 0.2), (0.004, 0.4)]) {
        near(axis.position, position_m);
        near(axis.velocity, speed);
    }
    device.step(0.0, &pushing([4.0, 8.0, 0.0]));
    assert_eq!(told.borrow().forces.last(), Some(&Some([2.0, 0.0, -1.0])));
    device.step(0.0, &Actuators::default());
    assert_eq!(told.borrow().forces.last(), Some(&None), "motors that are off let go");
    device.idle();
    assert_eq!(told.borrow().forces.last(), Some(&None));
}

#[test]
fn a_force_fades_with_the_age_of_its_reading() {
    let silent = Duration::from_millis(50);
    for (age_ms, wanted) in [(0, 1.0), (25, 1.0), (30, 0.8), (45, 0.2), (50, 0.0), (70, 0.0)] {
        let left = share(Duration::from_millis(age_ms), silent);
        assert!((left - wanted).abs() < 1e-12, "{age_ms} ms: {left}");
    }
    let (mut device, told) = attach(able(), &DeviceOptions::default(), &[]).expect("fit");
    told.borrow_mut().sensed = Some(at([0.1, 0.2, 0.3], Duration::from_millis(60)));
    let gone = device.look().expect_err("too old");
    assert!(gone.fault == DeviceFault::Silent && gone.cause.contains("of 50 allowed"), "{gone}");
    device.step(0.0, &pushing([1.0; 3]));
    assert_eq!(told.borrow().forces.last(), Some(&Some([0.0; AXES])));
}

/// A process that was stopped for longer than the device waits, and whose device tells of itself before the tick is asked for, does not go on.
#[test]
fn an_end_that_stood_still_does_not_go_on() {
    let options = DeviceOptions { silent_s: 0.02, ..DeviceOptions::default() };
    let (mut device, told) = attach(able(), &options, &[]).expect("a device");
    // How long it takes until the first tick is nobody's pause.
    std::thread::sleep(Duration::from_millis(30));
    told.borrow_mut().sensed = Some(at([0.1, 0.2, 0.3], Duration::ZERO));
    device.look().expect("the first tick");
    std::thread::sleep(Duration::from_millis(30));
    told.borrow_mut().sensed = Some(at([0.1, 0.2, 0.3], Duration::ZERO));
    let gone = device.look().expect_err("a pause");
    assert_eq!(gone.fault, DeviceFault::LetGo);
    assert!(gone.cause.contains("stood still for 3") && gone.cause.contains("of 20 allowed"), "{gone}");
}

/// A device that tells again and again, each time as new, that it moves, and always at one place: until it moves again it is as old as that.
#[test]
fn a_state_that_is_frozen_is_as_old_as_when_it_froze() {
    let (mut device, told) = attach(able(), &DeviceOptions::default(), &[]).expect("fit");
    let tell = |position_m: [f64; AXES], velocity_m_per_s: [f64; AXES], buttons: u8| {
        told.borrow_mut().sensed = Some(Sensed { velocity_m_per_s, buttons, ..at(position_m, Duration::ZERO) });
    };
    let began = Instant::now();
    let wait = |device: &mut Attached<3>, velocity: f64| {
        std::thread::sleep(Duration::from_millis(2));
        tell([0.1, 0.2, 0.3], [velocity, 0.0, 0.0], 1);
        device.look()
    };
    while began.elapsed() < Duration::from_millis(80) {
        wait(&mut device, 0.0).expect("a hand at rest may be at rest");
    }
    let froze = Instant::now();
    let gone = loop {
        if let Err(gone) = wait(&mut device, 0.2) {
            break gone;
        }
        assert!(froze.elapsed() < Duration::from_secs(5), "frozen for 5 s, and believed");
        assert!(device.clutches(0.0) == (device.clutch == 1), "buttons are heard");
    };
    assert!(gone.fault == DeviceFault::Silent && froze.elapsed() > Duration::from_millis(50), "{gone}");
}

#[test]
fn what_no_hand_can_do_is_no_reading() {
    let jumps = [[0.15, 0.2, 0.3], [f64::NAN, 0.2, 0.3]];
    for place in jumps {
        let (mut device, told) =
            attach(able(), &DeviceOptions::default(), &["safety.max_speed_m_per_s=2"]).expect("fit");
        told.borrow_mut().sensed = Some(at([0.1005, 0.2, 0.3], Duration::ZERO));
        device.look().expect("half a millimetre is nothing");
        told.borrow_mut().sensed = Some(at(place, Duration::ZERO));
        assert_eq!(device.look().expect_err("no hand").fault, DeviceFault::Implausible);
    }
    let (mut device, told) = attach(able(), &DeviceOptions::default(), &[]).expect("fit");
    told.borrow_mut().gone = Some(Gone::new(DeviceFault::Stopped, "closed"));
    assert_eq!(device.look().expect_err("stopped").to_string().split(':').next(), Some("fault 24"));
}

/// Numbers go on where those of a peer end, and none stands for two things.
#[test]
fn no_number_of_a_fault_is_used_twice() {
    for fault in DeviceFault::ALL {
        assert_eq!(Fault::from_number(fault as u8), None, "{}", fault.explain());
    }
}
