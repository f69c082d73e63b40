//! Bridges or amplifiers behind the PWM, with the board's own encoders: [`bridges`], [`encoders`], the loop in [`current`], the order in [`gate`].

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::device::motor::Duty;
use cohold_core::device::stage::Measured;
use cohold_core::names::MotorDrive;
use cohold_core::safety::Fault;
use cohold_core::settings::{Refused, Settings};
use firmware_parts::exchange::Latest;
use firmware_parts::image::{Actuators, JOINTS};
use firmware_parts::rate::Rate;
use firmware_parts::signals::Signals;
use static_cell::StaticCell;

use super::{Cut, Drive, Sensed};
use crate::board::current::{self, Order, Power, Stage, Sums};
use crate::board::encoders::{self, Encoders};
use crate::board::{bridges, gate, legs};

/// Two bridges with a current loop, or amplifiers.
pub(crate) struct Pwm {
    /// The current loop's interrupt.
    stage: Stage,
    /// Bridges or amplifiers are driven, or waking.
    driving: bool,
    /// Ticks since they were to be enabled, until they are awake: those of [`bridges::WAKES`] and one, of amplifiers [`gate::SEEN`].
    awake: u32,
    /// Ticks for which amplifiers that are disabled still have their command.
    going: u32,
    /// Their outputs were turned on.
    outputs: bool,
    encoders: Encoders,
}

/// What the settings make of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// The current loop; none where amplifiers make the current.
    power: Option<Power>,
    encoders: encoders::Plan,
    /// Ticks until bridges are awake, and until amplifiers have let go.
    wakes: u32,
    lets_go: u32,
}

impl Drive for Pwm {
    type Plan = Plan;

    fn plan(settings: &Settings, rate: Rate) -> Result<Self::Plan, Refused<'static>> {
        let power = match settings.motor.drive {
            MotorDrive::CurrentLoop => Some(Power::build(settings, rate)?),
            MotorDrive::Amplifier => None,
        };
        let (wakes, lets_go) = (rate.ticks(bridges::WAKES), rate.ticks(gate::LETS_GO));
        Ok(Plan { power, encoders: encoders::Plan::build(settings)?, wakes, lets_go })
    }

    fn start(signals: &'static Signals) -> Self {
        static ORDERS: StaticCell<Latest<Order>> = StaticCell::new();
        static SUMS: StaticCell<Latest<Sums>> = StaticCell::new();
        let (orders_in, orders) = ORDERS.init_with(|| Latest::new(Order::default())).split();
        let (sums_in, sums) = SUMS.init_with(|| Latest::new(Sums::default())).split();
        current::prepare(orders, sums_in);
        let encoders = Encoders::start(signals);
        Self { stage: Stage::new(orders_in, sums), driving: false, awake: 0, going: 0, outputs: false, encoders }
    }

    fn says(signals: &Signals) -> [Option<&'static str>; 2] {
        Encoders::says(signals)
    }

    #[inline(always)]
    fn sense(&mut self, plan: &Self::Plan, stage: &mut Option<Measured<JOINTS>>) -> Sensed {
        let mut fault = None;
        if let Some(power) = &plan.power {
            *stage = self.stage.measured(power);
            fault = if stage.is_none() { Some(Fault::LoopMissed) } else { None };
        }
        Sensed { counts: self.encoders.read(&plan.encoders, self.driving, &mut fault), fault }
    }

    #[inline(always)]
    fn marks(&mut self) -> Option<[Marks; JOINTS]> {
        self.encoders.marks()
    }

    #[inline(always)]
    fn went_off(&self) -> bool {
        self.outputs && !bridges::live()
    }

    fn cut(&self, plan: &Self::Plan) -> Cut {
        let Cut { by_stop, fault } = bridges::cut();
        // PE14 fell with the outputs, and nobody has taken the enable line yet.
        let passes = plan.power.is_none() && legs::gate_passes();
        Cut { by_stop, fault: if passes { Some(Fault::EnableGate) } else { fault } }
    }

    /// The outputs of bridges are on when they have been enabled for long enough to be awake, and while a probe looks whether what is not
    /// enabled stays off. Of amplifiers it is the other way round: outputs are on, at no current, before they are enabled ([`gate`]).
    #[inline(always)]
    fn act(&mut self, plan: &Self::Plan, actuators: &Actuators, counts: [Counts; JOINTS]) -> Result<(), Fault> {
        if !self.driving {
            (self.driving, self.going) = (true, 0);
            self.encoders.forget();
            bridges::forget();
        }
        let outputs = if let Some(power) = &plan.power {
            self.awake = if actuators.enable { (self.awake + 1).min(plan.wakes + 1) } else { 0 };
            self.stage.act(power, actuators, counts);
            bridges::enable(actuators.enable);
            !actuators.enable || self.awake > plan.wakes
        } else {
            if self.awake == gate::SEEN && actuators.enable {
                legs::amplify(actuators.duties);
            } else {
                self.enable_amplifiers(actuators.duties, actuators.enable)?;
            }
            true
        };
        if outputs != self.outputs {
            self.outputs = outputs;
            if outputs {
                bridges::on();
            } else {
                bridges::rest();
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn rest(&mut self, plan: &Self::Plan, counts: [Counts; JOINTS]) {
        if self.driving && plan.power.is_none() {
            self.going = plan.lets_go;
        }
        if let Some(left) = self.going.checked_sub(1) {
            self.going = left;
            gate::shut();
        } else {
            bridges::off();
        }
        self.stage.rest(counts);
        (self.driving, self.awake, self.outputs) = (false, 0, false);
    }
}

impl Pwm {
    /// A tick of enabling amplifiers; an error: their gate does not work, and they are disabled. The outputs go off as after any other fault,
    /// two milliseconds later: what is enabled without a gate needs its command until it has let go.
    #[cold]
    #[inline(never)]
    #[unsafe(link_section = ".itcm.gate")]
    fn enable_amplifiers(&mut self, duties: [Duty; JOINTS], enable: bool) -> Result<(), Fault> {
        self.awake = if enable { self.awake + 1 } else { 0 };
        if gate::step(self.awake, duties) {
            return Ok(());
        }
        (self.awake, self.outputs) = (0, false);
        Err(Fault::EnableGate)
    }
}
