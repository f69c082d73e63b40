//! Local rendering: the force that a hand feels from what it knows of a world, 1000 times a second.
//!
//! The force of every contact is `cohold_core`'s: walls and blocks are polygons and bodies discs of
//! [`super::springs`], which push the hand out of the nearest side; a strip pushes to its free side. A strip is a
//! chain of masses that moves while it is touched and afterwards, advanced by `cohold_core`'s integrator; every client has its
//! own, for in a static world nobody feels anybody else.
//!
//! **What is touched does not change under the hand.** A download, a new version or another server may bring, change or
//! take away objects at any time. An object that appears around the hand is felt once the hand has left it; one that is
//! touched is changed or taken away when the hand has left it. So no download makes a step in the force.
//!
//! **Limits**: those of [`super::springs`]; a strip that is approached from behind is not felt. Units SI; two
//! dimensions. Reference: architectures paper §2.2, complex shapes as springs and dampers along the normal.

use std::collections::BTreeMap;

use cohold_core::object::{Before, Integrator};
use cohold_core::{contact::Contact, model::Model as _, num::Motion, object::euler::SemiImplicit, settings::Settings};

use super::parameters::CONTROL_PERIOD_S;
use super::solid::{Frame, Solid, Vector, contact, dot, solid};
use super::springs::Pressed;
use crate::records::{Object, Strip};

/// A chain of masses between two fixed ends.
#[derive(Clone, Debug)]
struct Chain {
    frame: Frame,
    spring: f64,
    integrator: SemiImplicit<f64>,
    /// How far out each mass is, and how fast it moves.
    masses: Vec<(Motion<f64>, Before<f64>)>,
    /// Pushes of this tick, N.
    push: Vec<f64>,
    /// The hand was on the free side, or came from there.
    entered: bool,
    free: bool,
}

impl Chain {
    fn new(strip: &Strip) -> Self {
        let mut settings = Settings::default();
        settings.timing.control_period_s = CONTROL_PERIOD_S;
        settings.object.mass_kg = f64::from(strip.mass_kg);
        settings.object.damping_n_s_per_m = f64::from(strip.drag_n_s_per_m);
        settings.object.force_delay_ticks = 0.0;
        let count = strip.masses as usize;
        Self {
            frame: Frame::new([strip.from_x_m, strip.from_y_m], [strip.to_x_m, strip.to_y_m]),
            spring: f64::from(strip.spring_n_per_m),
            integrator: SemiImplicit::build(&settings).expect("any mass"),
            masses: vec![(Motion::REST, Before::default()); count],
            push: vec![0.0; count],
            entered: false,
            free: false,
        }
    }

    /// The motion of mass `at`, counted from 1; the ends are at rest.
    fn mass(&self, at: usize) -> Motion<f64> {
        at.checked_sub(1).and_then(|at| self.masses.get(at)).map_or(Motion::REST, |(motion, _)| *motion)
    }

    /// Force on the hand, and the chain one tick later.
    fn step(&mut self, contact: &Contact<f64>, hand: [Motion<f64>; 2]) -> Touch {
        let [along, out] = self.frame.local(hand.map(|axis| axis.position));
        let speed = dot(hand.map(|axis| axis.velocity), self.frame.out);
        let spacing = self.frame.length / (self.masses.len() + 1) as f64;
        let over = along > 0.0 && along < self.frame.length;
        let place = if over { along / spacing } else { 0.0 };
        let (left, share) = (place as usize, place - (place as usize) as f64);
        let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
        let (a, b) = (self.mass(left), self.mass(left + 1));
        let surface = Motion { position: mix(a.position, b.position), velocity: mix(a.velocity, b.velocity) };
        let depth = surface.position - out;
        // Felt from the moment the hand comes through the surface until it leaves it or its ends.
        self.entered = over && depth > 0.0 && (self.entered || self.free);
        self.free = depth <= 0.0;
        self.push.fill(0.0);
        let mut force = 0.0;
        if self.entered {
            // At the ends less and less is felt, down to nothing.
            let felt = depth.min(along).min(self.frame.length - along);
            force = contact.force(Motion { position: felt, velocity: surface.velocity - speed }, Motion::REST);
            for (mass, share) in [(left, 1.0 - share), (left + 1, share)] {
                if let Some(push) = mass.checked_sub(1).and_then(|at| self.push.get_mut(at)) {
                    *push -= share * force;
                }
            }
        }
        self.advance();
        Touch { depth: if self.entered { depth } else { 0.0 }, force: self.frame.out.map(|part| part * force) }
    }

    fn advance(&mut self) {
        let mut before = 0.0;
        for at in 0..self.masses.len() {
            let after = self.mass(at + 2).position;
            let (motion, state) = &mut self.masses[at];
            let here = motion.position;
            let force = self.spring * (before - 2.0 * here + after) + self.push[at];
            *motion = self.integrator.step(state, *motion, force);
            before = here;
        }
    }
}

#[derive(Clone, Debug)]
enum Form {
    Solid(Solid),
    Strip(Chain),
}

/// What the hand feels from one object.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    depth: f64,
    force: Vector,
}

/// One object as it is felt.
#[derive(Clone, Debug)]
struct Felt {
    object: Object,
    contact: Contact<f64>,
    form: Form,
    /// It appeared around the hand, which has not left it yet.
    around: bool,
    touched: bool,
}

impl Felt {
    /// An object that appears while the hand is at `hand`.
    fn new(object: Object, hand: Option<Vector>) -> Self {
        let mut form = match solid(&object.shape) {
            Ok(solid) => Form::Solid(solid),
            Err(strip) => Form::Strip(Chain::new(strip)),
        };
        let around = match (&mut form, hand) {
            (Form::Solid(solid), Some(hand)) => solid.depth(hand).is_some(),
            (Form::Strip(chain), Some(hand)) => {
                chain.free = chain.frame.local(hand)[1] >= 0.0;
                false
            }
            (_, None) => false,
        };
        Self { object, contact: contact(&object.shape), form, around, touched: false }
    }

    fn step(&mut self, hand: [Motion<f64>; 2]) -> Vector {
        let touch = match &mut self.form {
            Form::Strip(chain) => chain.step(&self.contact, hand),
            Form::Solid(solid) => {
                let Pressed { depth, force, .. } = solid.press(&self.contact, hand, [Motion::REST; 2]);
                self.around &= depth > 0.0;
                if self.around { Touch::default() } else { Touch { depth, force: force.map(|part| -part) } }
            }
        };
        self.touched = touch.depth > 0.0;
        touch.force
    }
}

/// Renders the objects of a world to a hand.
#[derive(Clone, Debug, Default)]
pub struct Renderer {
    felt: BTreeMap<u32, Felt>,
    /// What is known now, as far as it differs from what is felt: changed, or gone.
    waiting: BTreeMap<u32, Option<Object>>,
    /// Where the hand was last, m.
    hand: Option<Vector>,
}

impl Renderer {
    /// Takes over what is known now; what is touched stays as it is until it is left.
    pub fn know<'a>(&mut self, objects: impl IntoIterator<Item = &'a Object>) {
        let known: BTreeMap<u32, &Object> = objects.into_iter().map(|object| (object.id, object)).collect();
        self.waiting.clear();
        for (id, felt) in &self.felt {
            match known.get(id) {
                Some(object) if **object == felt.object => {}
                other => drop(self.waiting.insert(*id, other.map(|object| **object))),
            }
        }
        for (id, object) in known {
            self.felt.entry(id).or_insert_with(|| Felt::new(*object, self.hand));
        }
        self.settle();
    }

    fn settle(&mut self) {
        let (felt, hand) = (&mut self.felt, self.hand);
        self.waiting.retain(|id, next| {
            if felt.get(id).is_some_and(|felt| felt.touched) {
                return true;
            }
            match next {
                Some(object) => drop(felt.insert(*id, Felt::new(*object, hand))),
                None => drop(felt.remove(id)),
            }
            false
        });
    }

    /// Force on the hand, N; everything that moves is one tick later.
    pub fn step(&mut self, hand: [Motion<f64>; 2]) -> [f64; 2] {
        self.hand = Some(hand.map(|axis| axis.position));
        let mut sum = [0.0; 2];
        for felt in self.felt.values_mut() {
            let [x, y] = felt.step(hand);
            sum = [sum[0] + x, sum[1] + y];
        }
        if !self.waiting.is_empty() {
            self.settle();
        }
        sum
    }

    /// How many objects are felt.
    pub fn count(&self) -> usize {
        self.felt.len()
    }

    /// How many objects are touched.
    pub fn touched(&self) -> usize {
        self.felt.values().filter(|felt| felt.touched).count()
    }
}
