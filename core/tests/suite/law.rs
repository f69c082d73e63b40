//! A law from outside: one file with its name, its own keys and its state, held by a peer like any other.

use cohold_core::configured;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::power::Power;
use cohold_core::law::{AnyLaw, Coupled, Law, LawInfo, Observation, Packet, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::Solve;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::schema::Schema;
use cohold_core::settings::{Allowed, Key, Refused, SetError, Settings, Tables, Value};

const AHEAD: Key =
    Key::number("predict.ahead_s", 0.008, [0.0, 0.2], "s").means("How far the remote copy is carried on.");
const STOPS: Key = Key::flag("predict.stops", false).means("The remote copy is taken to be at rest.");

/// Power-domain, the remote copy carried on at its last velocity.
#[derive(Clone, Copy, Debug)]
struct Predict<S> {
    spring: Spring<S>,
    ahead: S,
    stops: bool,
}

configured!([S: Scalar] Predict<S> { spring, ahead, stops });

impl<S: Scalar> Law<S> for Predict<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "predict",
        keys: &[AHEAD, STOPS],
        gains: &["coordination.stiffness_n_per_m=310"],
        ..LawInfo::MOTION
    }];
    type State = Motion<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (ahead, stops) = (S::from_f64(settings.own(&AHEAD)), settings.own(&STOPS) != 0.0);
        Ok(Self { spring: Spring::build(settings), ahead, stops })
    }
    fn start(&self, local: Motion<S>) -> Motion<S> {
        local
    }
    fn receive(&self, desired: &mut Motion<S>, Packet { motion, .. }: Packet<S>) {
        let carried = Motion { position: motion.position + self.ahead * motion.velocity, ..motion };
        *desired = if self.stops { Motion::at(carried.position) } else { carried };
    }
    fn couple(&self, desired: &mut Motion<S>, seen: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let force = self.spring.force(*desired, seen.local, solve);
        Coupled { desired: *desired, force, ..Coupled::default() }
    }
    fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}

const SCHEMA: Schema = Schema::new(Predict::<f64>::LAWS);

fn settings(changes: &[(&str, Value<'static>)]) -> Settings {
    let mut settings = Settings::default();
    for (key, value) in [("coordination.comm", Value::Text("predict"))].iter().chain(changes) {
        SCHEMA.set(&mut settings, key, *value).unwrap_or_else(|error| panic!("{key}: {error:?}"));
    }
    settings
}

/// Where an armed peer with this law takes the other copy to be that passes the origin at 1 m/s.
fn desired<S: Scalar>(settings: &Settings) -> Motion<f64> {
    let mut peer = Peer::<S, Predict<S>>::new(settings, [Motion::REST; AXES]).expect("good settings");
    peer.command(Command::Arm);
    peer.hear(&[Packet { motion: Motion { position: S::ZERO, velocity: S::ONE }, ..Packet::default() }]);
    peer.exchange();
    peer.tick(&Sensors::of(Reading::Exact([Motion::REST; AXES])));
    let seen = peer.observed()[0].desired;
    Motion { position: seen.position.to_f64(), velocity: seen.velocity.to_f64() }
}

#[test]
fn a_law_from_outside_runs_with_keys_of_its_own() {
    assert_eq!(desired::<f64>(&settings(&[])), Motion { position: 0.008, velocity: 1.0 });
    let configured = settings(&[("predict.ahead_s", Value::Number(0.125)), ("predict.stops", Value::Flag(true))]);
    assert_eq!(desired::<f64>(&configured), Motion::at(0.125));
    assert_eq!(desired::<f32>(&configured), Motion::at(0.125));
    let keys: Vec<&str> = SCHEMA.keys().map(|key| key.name).collect();
    assert_eq!(keys.len(), <Settings as Tables>::KEYS.len() + 2);
    assert!(keys.ends_with(&["predict.ahead_s", "predict.stops"]));
    let configured = |key| SCHEMA.get(&configured, key);
    assert_eq!(
        (configured("predict.ahead_s"), configured("predict.stops")),
        (Some(Value::Number(0.125)), Some(Value::Flag(true)))
    );
}

#[test]
fn a_wrong_value_of_an_own_key_is_refused_by_name() {
    let mut settings = settings(&[]);
    let before = settings;
    for (value, said) in [
        (Value::Number(1.0), "predict.ahead_s = 1 is not allowed: it must be a number from 0 to 0.2 s"),
        (Value::Number(f64::NAN), "predict.ahead_s = NaN is not allowed: it must be a number from 0 to 0.2 s"),
        (Value::Flag(true), "predict.ahead_s = true is not allowed: it must be a number from 0 to 0.2 s"),
    ] {
        let Err(SetError::Refused(refused)) = SCHEMA.set(&mut settings, "predict.ahead_s", value) else {
            panic!("taken")
        };
        assert_eq!(refused.to_string(), said);
    }
    assert_eq!(settings.set("predict.ahead_s", Value::Number(0.1)), Err(SetError::Unknown), "no built-in law has it");
    assert_eq!(settings, before);
}

/// What two peers compare before they meet must not depend on who spelled a default out, or in which order.
#[test]
fn settings_that_say_the_same_are_the_same() {
    let (ahead, stops) = (("predict.ahead_s", Value::Number(0.1)), ("predict.stops", Value::Flag(true)));
    assert_eq!(settings(&[ahead, stops]), settings(&[stops, ahead]));
    assert_eq!(settings(&[ahead, ("predict.ahead_s", Value::Number(0.008))]), settings(&[]));
    let common: Vec<_> = settings(&[ahead]).common().filter(|(table, ..)| *table == "predict").collect();
    assert_eq!(common, [("predict", "ahead_s", Value::Number(0.1))]);
}

/// Every peer has room for the largest state: a law that is new must not make it larger.
#[test]
fn no_state_of_a_law_is_larger_than_the_self_timed_line_s() {
    use cohold_core::law::{AnyLawState, self_timed};
    let largest = size_of::<<self_timed::SelfTimed<f32> as Law<f32>>::State>();
    let room = size_of::<AnyLawState<f32>>();
    assert!(room <= largest + 8, "{room} bytes, {largest} of the line");
}

#[test]
fn a_peer_refuses_a_law_that_it_does_not_hold() {
    let here = [Motion::<f32>::REST; AXES];
    let refused = Peer::<f32, AnyLaw<f32>>::new(&settings(&[]), here).expect_err("another law").to_string();
    let names: Vec<String> = AnyLaw::<f32>::LAWS.iter().map(|law| format!("{:?}", law.name)).collect();
    let names = names.join(", ");
    assert_eq!(refused, format!("coordination.comm = \"predict\" is not allowed: it must be one of {names}"));
    assert!(names.starts_with("\"power\", \"p-plus-d\"") && names.ends_with("\"none\""), "{names}");
    let refused = Peer::<f32, Power<f32>>::new(&Settings::default(), here).expect_err("another law");
    assert_eq!(refused.allowed, Allowed::Laws(Power::<f32>::LAWS));
}
