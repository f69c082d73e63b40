//! A shared environment as a page has it: what all of them have in common, around the little in which they differ.

use cohold_sim::engine::{Actor, Engine, Seat};
use cohold_sim::network::{link::Route, rule::Direction};
use cohold_sim::scene::Scene;

use super::environment::{ARMED, Command, Environment, MOST, OFF, Sample, Standing};
use super::partner::Model;
use super::session::{PERIOD_S, same_but_for_network};
use cohold_cli::Failure;

/// Who holds a hand, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Held {
    /// Whoever plays when nobody does.
    ByNobody,
    /// A person who has let go.
    Free,
    /// A person, whose pointer is here, m.
    At([f64; 2]),
}

/// What a shared environment is.
pub(super) trait Play: Sized {
    /// At rest, in this scene.
    fn open(scene: &Scene) -> Result<Self, Failure>;

    /// Who holds hand 0 or 1 in the next tick.
    fn hold(&mut self, hand: usize, held: Held);

    /// Who holds the hands that nobody holds, where that can be chosen.
    fn partner(&mut self, _model: Model) {}

    /// Steps the environment by one tick.
    fn step(&mut self);

    /// The numbers of its columns, but for the last one, which says how often it has started anew.
    fn numbers(&self, number: &mut dyn FnMut(f64));

    /// How many sit at its network.
    fn seats(&self) -> usize;

    /// The network from one of them to another, to be changed in flight.
    fn route(&mut self, from: usize, to: usize) -> &mut Route;

    /// The seat of hand 1, whose line is cut.
    fn seat(&self) -> usize {
        1
    }

    /// Whether what is played is over, and begins anew.
    fn is_over(&self) -> bool {
        false
    }

    /// Mode of the first two.
    fn modes(&self) -> [u8; 2] {
        [ARMED; 2]
    }
}

/// The scene's network on the way from one seat to another; every way has a stream of random numbers of its own.
fn scene_route(scene: &Scene, from: usize, to: usize) -> Route {
    let direction = if from < to { Direction::OneToTwo } else { Direction::TwoToOne };
    Route::of_scene(scene, direction, (16 * from + to) as u32)
}

/// What is between these seats: the scene's network, and a tick of the page.
pub(super) fn engine<A: Actor<usize>>(scene: &Scene, seats: Vec<Seat<A>>) -> Engine<A> {
    Engine::new((1e9 * PERIOD_S) as u64, seats, |from, to| scene_route(scene, from, to))
}

/// A shared environment that is played.
pub(super) struct SharedEnvironment<P> {
    scene: Scene,
    play: P,
    model: Model,
    /// It stands since a stop.
    still: bool,
    cut: bool,
    restarts: u32,
    last: Sample,
}

impl<P: Play> SharedEnvironment<P> {
    /// At rest, in this scene.
    pub(super) fn new(scene: &Scene) -> Result<Self, Failure> {
        let (play, last) = (P::open(scene)?, [f32::NAN; MOST]);
        Ok(Self { scene: scene.clone(), play, model: Model::default(), still: false, cut: false, restarts: 0, last })
    }

    fn anew(&mut self) -> Result<(), Failure> {
        self.play = P::open(&self.scene)?;
        self.play.partner(self.model);
        self.restarts += 1;
        self.cut(self.cut);
        Ok(())
    }

    fn cut(&mut self, cut: bool) {
        self.cut = cut;
        let own = self.play.seat();
        for other in (0..self.play.seats()).filter(|other| *other != own) {
            self.play.route(own, other).cut = cut;
            self.play.route(other, own).cut = cut;
        }
    }
}

impl<P: Play> Environment for SharedEnvironment<P> {
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Stop => self.still = true,
            Command::Start => {
                self.still = false;
                self.anew()?;
            }
            Command::Cut(cut) => self.cut(cut),
            Command::Partner(model) => {
                self.model = model;
                self.play.partner(model);
            }
            Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Failure> {
        let before = std::mem::replace(&mut self.scene, scene);
        if !same_but_for_network(&before, &self.scene) {
            return self.anew();
        }
        let seats = self.play.seats();
        for (from, to) in (0..seats * seats).map(|seat_pair| (seat_pair / seats, seat_pair % seats)) {
            let Route { delay_ns, rule, .. } = scene_route(&self.scene, from, to);
            let route = self.play.route(from, to);
            (route.delay_ns, route.rule) = (delay_ns, rule);
        }
        Ok(())
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32) {
        let at = at.filter(|_| restarts == self.restarts);
        self.play.hold(hand, at.map_or(Held::Free, |[along, across, _]| Held::At([along, across])));
    }

    fn play(&mut self, hand: usize) {
        self.play.hold(hand, Held::ByNobody);
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        if self.still {
            return Ok(self.last);
        }
        if self.play.is_over() {
            self.anew()?;
        }
        self.play.step();
        let (mut at, mut sample) = (0, [f32::NAN; MOST]);
        self.play.numbers(&mut |number| {
            if let Some(to) = sample.get_mut(at) {
                *to = number as f32;
            }
            at += 1;
        });
        sample[MOST - 1] = self.restarts as f32;
        self.last = sample;
        Ok(sample)
    }

    fn standing(&self) -> Standing {
        let modes = if self.still { [OFF; 2] } else { self.play.modes() };
        Standing { modes, cut: self.cut, partner: self.model.number() }
    }
}
