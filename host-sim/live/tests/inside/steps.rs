//! Between two steps the device tells where it is, however long its line takes to come up again.

use cohold_sim::device::Gone;

use super::super::Abilities;
use super::*;

/// A device that tells nothing new until then, and then is asked and answers at once.
struct Late {
    abilities: Abilities,
    newest: Sensed,
    until: Instant,
}

impl Late {
    fn by(late: Duration) -> Self {
        let now = Instant::now();
        let newest = Sensed { position_m: [0.0; AXES], velocity_m_per_s: [0.0; AXES], between: [now; 2], buttons: 0 };
        Self { abilities: Abilities::default(), newest, until: now + late }
    }
}

impl Port for Late {
    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn read(&mut self) -> Result<Option<Sensed>, Gone> {
        let now = Instant::now();
        if now >= self.until {
            self.newest.between = [now; 2];
        }
        Ok(Some(self.newest))
    }

    fn write(&mut self, force_n: Option<[f64; AXES]>) {
        assert_eq!(force_n, None, "nothing pushes before the device is back");
    }
}

fn rests(late: Duration) -> (Result<(), Error>, Result<Sensed, Error>) {
    let mut port = Late::by(late);
    let nobody = |_: &str| Ok(());
    let mut trial = Trial::new(&mut port, &nobody, 1, Duration::from_millis(200), 0.02);
    (trial.rest(), trial.tick(None))
}

#[test]
fn a_device_whose_line_comes_up_late_is_waited_for() {
    let (rest, tick) = rests(Duration::from_millis(400));
    rest.expect("it is back");
    tick.expect("its place is new");
}

#[test]
fn a_device_that_does_not_come_back_is_not_waited_for_without_end() {
    let begun = Instant::now();
    let why = rests(Duration::from_secs(3_600)).0.expect_err("it is not back").to_string();
    assert!(why.contains("no new position for 2 s") && begun.elapsed() < 2 * RETURNS, "{why}");
}
