//! What a person does at the bench: says lines to the boards, sets them up, lets go of devices and takes hold of them again,
//! checks, arms.
//!
//! Settings go to the boards as a person's would: lines of text to the operator's port, then `apply`, then `check`, then `arm`.
//! For the check, and for any probe, the devices are let go of: [`Bench::let_go`]. Armed boards engage step by step once they
//! hear each other; until they are engaged the hands hold still, and there the experiment begins: from rest and with the
//! coordination acting in full, as cohold begins its own.

use cohold_cli::Failure;
use cohold_core::names::Choice;
use cohold_core::settings::{Settings, Value};
use cohold_sim::scene::{PlantFault, Scene};
use firmware_parts::record::ENGAGED;

use super::device::Device;
use super::{Bench, PERIOD_NS};
use crate::part::MOTORS;
use crate::part::motors::Act;

/// The lines that bring a board from whatever it has to `settings`.
fn lines(settings: &Settings) -> Vec<String> {
    let defaults = firmware_parts::kept::defaults();
    let mut lines = vec!["defaults".to_owned()];
    for key in Settings::keys() {
        let (wanted, default) = (settings.get(key.name), defaults.get(key.name));
        // The side is by the strap.
        if key.name == "contact.side" || wanted == default {
            continue;
        }
        lines.push(match wanted.expect("a listed key has a value") {
            Value::Number(number) => format!("set {} {number:?}", key.name),
            Value::Flag(flag) => format!("set {} {flag}", key.name),
            Value::Text(text) => format!("set {} {text}", key.name),
        });
    }
    lines.push("apply".to_owned());
    lines
}

impl Bench {
    /// Says a line to a board (1 or 2) and gives its answer.
    ///
    /// # Panics
    /// It does not answer within a second.
    pub fn ask(&mut self, number: usize, line: &str) -> String {
        let before = self.pc.answers[number - 1].len();
        self.send(number, line);
        for _ in 0..1000 * PERIOD_NS / self.period_ns {
            self.step();
            if let Some(answer) = self.pc.answers[number - 1].get(before) {
                return answer.clone();
            }
        }
        panic!("board {number} does not answer {line:?}");
    }

    /// Says a line to a board (1 or 2) and waits for nothing.
    pub fn send(&mut self, number: usize, line: &str) {
        self.pc.say(number, line);
        self.talk();
    }

    /// Holds the blue button of every board down, or lets go of it; takes effect at the next stop.
    pub fn hold_buttons(&mut self, held: bool) {
        self.inputs.iter_mut().for_each(|inputs| inputs.button = Some(held));
    }

    /// Tells a board (1 or 2) with no other settings that amplifiers make its motors' currents: what the bench's devices are without a scene.
    ///
    /// # Panics
    /// It does not take it.
    pub fn tell_of_amplifiers(&mut self, number: usize) {
        self.input(number).button = Some(true);
        self.run_for_ms(100);
        for line in ["set motor.drive amplifier", "apply"] {
            let answer = self.ask(number, line);
            assert!(answer.starts_with("ok"), "{line}: {answer}");
        }
        self.input(number).button = Some(false);
    }

    /// Brings every board to the scene, at the board, and puts a device on it; disarmed still.
    ///
    /// # Errors
    /// What a board says against a setting.
    pub fn set_up(&mut self, scene: &Scene) -> Result<(), Failure> {
        self.set_up_each(&vec![scene.clone(); self.nodes.len()])
    }

    /// [`Bench::set_up`] of a scene for each board, which differ in what a device is and how it is driven.
    ///
    /// # Errors
    /// As [`Bench::set_up`].
    pub fn set_up_each(&mut self, scenes: &[Scene]) -> Result<(), Failure> {
        self.scenes = scenes.to_vec();
        let (timing, boards) = (&self.scenes[0].peer.timing, self.scenes.iter().enumerate());
        let ticks_per_packet = u64::from(timing.ticks_per_packet);
        self.devices = boards.map(|(index, scene)| Some(Device::new(scene, index))).collect();
        for ((device, scene), inputs) in self.devices.iter().flatten().zip(scenes).zip(&mut self.inputs) {
            inputs.counts = Some(device.motors().counts);
            inputs.motors = Some(device.stage());
            inputs.counts_per_rev = Some(scene.peer.encoder.counts_per_rev);
        }
        self.hold_buttons(true);
        for (index, scene) in scenes.iter().enumerate() {
            for line in lines(&scene.peers()[index]) {
                let answer = self.ask(index + 1, &line);
                if !answer.starts_with("ok") {
                    return Err(format!("board {}: {line}: {answer}", index + 1).into());
                }
            }
        }
        self.hold_buttons(false);
        self.pace(&scenes[0]);
        // The scene is taken at the next packet boundary, and the peers meet again under it.
        self.run_for_ms(2 * ticks_per_packet);
        self.settle()
    }

    /// Waits until two boards talk to each other under the settings that they have.
    ///
    /// # Errors
    /// They do not.
    fn settle(&mut self) -> Result<(), Failure> {
        if self.nodes.len() == 2 {
            let scene = &self.scenes[0];
            let (timing, safety) = (&scene.peer.timing, &scene.peer.safety);
            let steps = u64::from(timing.packet_periods(safety.disengage_s - safety.fade_s));
            let delay = u64::from(scene.world.network.one_way_delay_packets);
            // Twice what it takes without losses.
            self.engaging = u64::from(timing.ticks_per_packet) * (2 * steps + 2 * delay + 8);
            let met = (0..100).any(|_| {
                self.run_for_ms(10);
                (1..=2).all(|number| self.ask(number, "status").contains("link running"))
            });
            if !met {
                return Err(format!("the boards do not meet: {}", self.ask(1, "status")).into());
            }
        }
        Ok(())
    }

    /// Lets go of the devices: until [`Bench::take_hold`] they are `device` (as the scene has it, when `None`), nobody pushes
    /// them, and what moves them is their own board.
    pub fn let_go(&mut self, device: Option<&Scene>) {
        let scenes = self.scenes.iter().map(|own| {
            let mut scene = device.unwrap_or(own).clone();
            scene.users = Default::default();
            scene
        });
        let counts = |index: usize| {
            let now = self.loose.get(index).or(self.devices[index].as_ref());
            now.map_or([0; MOTORS], |device| device.motors().counts)
        };
        self.loose = scenes.enumerate().map(|(i, scene)| Device::at(&scene, i, counts(i))).collect();
        for (device, inputs) in self.loose.iter().zip(&mut self.inputs) {
            inputs.motors = Some(device.stage());
        }
    }

    /// Moves the loose device of a board by hand along its first axis, evenly, and leaves it at rest.
    pub fn carry(&mut self, number: usize, metres: f64, ms: u64) {
        for _ in 0..ms {
            self.loose[number - 1].motors().act(Act::Carry(metres / ms as f64));
            self.step();
            self.loose[number - 1].motors().act(Act::Carry(0.0));
        }
    }

    /// Puts every device back where it was, and gives it back to its user.
    pub fn take_hold(&mut self) {
        /// Slow enough for any limit of speed in these tests, counts in a period.
        const STRIDE: i64 = 100;
        let whereabouts = |device: &Device| device.motors().counts;
        let loose = std::mem::take(&mut self.loose);
        let mut now: Vec<[i64; MOTORS]> = loose.iter().map(whereabouts).collect();
        let home: Vec<[i64; MOTORS]> =
            self.devices.iter().map(|device| device.as_ref().map_or([0; MOTORS], whereabouts)).collect();
        self.inputs.iter_mut().for_each(|inputs| inputs.motors = Some(None));
        let held = std::mem::take(&mut self.devices);
        self.devices = held.iter().map(|_| None).collect();
        while now != home {
            for ((now, home), inputs) in now.iter_mut().zip(&home).zip(&mut self.inputs) {
                for (counts, home) in now.iter_mut().zip(home) {
                    *counts += (home - *counts).clamp(-STRIDE, STRIDE);
                }
                inputs.counts = Some(*now);
            }
            self.step();
        }
        for (device, inputs) in held.iter().flatten().zip(&mut self.inputs) {
            inputs.motors = Some(device.stage());
        }
        self.devices = held;
        self.run_to(self.now_ns + self.period_ns);
    }

    /// Presses the emergency stop of a board (1 or 2), each contact that is not bridged, or releases it; takes effect at the next stop.
    pub fn press_stop(&mut self, number: usize, pressed: bool) {
        let [first, second] = self.bridged;
        self.input(number).press = (!first).then_some(pressed);
        if !second {
            self.cut_supply(number, pressed);
        }
    }

    /// The supply of a board's (1 or 2) bridges is switched off, or on again, whoever does it.
    pub fn cut_supply(&mut self, number: usize, cut: bool) {
        if let Some(device) = self.device(number) {
            device.motors().act(Act::Cut(cut));
        }
    }

    /// Supply of the bridges of a board (1 or 2), V; 0 without a device.
    pub fn supply_v(&self, number: usize) -> f64 {
        self.device(number).map_or(0.0, |device| device.motors().supply_v())
    }

    fn device(&self, number: usize) -> Option<&Device> {
        self.loose.get(number - 1).or(self.devices[number - 1].as_ref())
    }

    /// Something goes wrong with the first joint of a board's (1 or 2) device, now.
    pub fn fail(&mut self, number: usize, fault: PlantFault) {
        let which = PlantFault::ALL.iter().position(|known| *known == fault).expect("it is one of all");
        if let Some(device) = &self.devices[number - 1] {
            device.motors().act(Act::Fails(which));
        }
    }

    /// The device of a board is as good as new, where it was, and nobody moves it until it is driven.
    pub fn mend(&mut self, number: usize) {
        let Some(device) = &mut self.devices[number - 1] else { return };
        let counts = device.motors().counts;
        *device = Device::at(&self.scenes[number - 1], number - 1, counts);
        self.inputs[number - 1].motors = Some(device.stage());
    }

    /// The answer to `probed` once the probe of a board is over.
    ///
    /// # Panics
    /// It takes longer than the longest probe.
    pub fn probed(&mut self, number: usize) -> String {
        for _ in 0..200 {
            let answer = self.ask(number, "probed");
            if !answer.contains(" running") {
                return answer;
            }
            self.run_for_ms(50);
        }
        panic!("the probe of board {number} does not end");
    }

    /// Checks the signs of every joint in use, as a person does before arming: hands off, check, the device put back.
    ///
    /// # Errors
    /// What a board found.
    pub fn check(&mut self, number: usize) -> Result<(), Failure> {
        self.let_go(None);
        let mut outcome = Ok(());
        for joint in 1..=self.scenes[number - 1].peer.axis.count {
            let begun = self.ask(number, &format!("check {joint}"));
            let answer = if begun.starts_with("ok") { self.probed(number) } else { begun };
            if !answer.contains("; agree: ") {
                outcome = Err(format!("board {number}, joint {joint}: {answer}").into());
            }
        }
        self.take_hold();
        outcome
    }

    /// Checks the signs of every board, starts the scene anew, asks for every tick, arms all boards, and waits until they are
    /// engaged and the devices have begun to move.
    ///
    /// # Panics
    /// A board does not pass the check or does not arm, or two do not engage.
    pub fn arm(&mut self) {
        for number in 1..=self.nodes.len() {
            self.check(number).unwrap_or_else(|found| panic!("{found}"));
            assert_eq!(self.ask(number, "apply"), "ok applied");
        }
        self.run_for_ms(2 * u64::from(self.scenes[0].peer.timing.ticks_per_packet));
        self.settle().unwrap_or_else(|found| panic!("{found}"));
        for number in 1..=self.nodes.len() {
            assert!(self.ask(number, "stream 1").starts_with("ok"));
        }
        let before: Vec<usize> = self.pc.answers.iter().map(Vec::len).collect();
        for number in 1..=self.nodes.len() {
            self.send(number, "arm");
        }
        (0..self.engaging).for_each(|_| self.step());
        while self.ticks < 24 {
            assert!(self.stops < 1_000_000, "the boards do not arm");
            self.step();
            for (index, before) in before.iter().enumerate().take(self.nodes.len()) {
                let answer = self.pc.answers[index].get(*before).map(String::as_str);
                assert!(matches!(answer, None | Some("ok armed")), "board {}: {answer:?}", index + 1);
            }
        }
        for number in 1..=self.nodes.len() {
            let first = self.armed_ticks(number).first().expect("its first ticks are here");
            assert!(self.nodes.len() == 1 || first.flags() & ENGAGED != 0, "board {number} is not engaged");
        }
        self.checkpoint();
    }
}
