//! A shared environment as a page has it: what all of them have in common, around the little in which they differ.

use cohold_live::playable::{Held, Play, Playable, route};
use cohold_sim::network::link::Route;
use cohold_sim::scene::Scene;

use super::environment::{Command, Environment, MOST, OFF, Sample, Standing, number_of};
use super::partner::{Model, Partner};
use super::session::{PERIOD_S, same_but_for_network};
use cohold_cli::Failure;

/// What those do who hold the hands beyond the second: neither can have its way alone.
const THERE: [Model; 2] = [Model::CarriesOn, Model::Resists];

/// A shared environment that is played.
pub(super) struct SharedEnvironment {
    of: &'static Playable,
    scene: Scene,
    play: Box<dyn Play>,
    model: Model,
    /// Who holds each hand while no person does, if the environment says where its device is.
    partners: [Partner; 2 + THERE.len()],
    /// It stands since a stop.
    still: bool,
    cut: bool,
    restarts: u32,
    last: Sample,
}

impl SharedEnvironment {
    /// At rest, in this scene.
    pub(super) fn new(of: &'static Playable, scene: &Scene) -> Result<Self, Failure> {
        let (play, scene, model) = ((of.open)(scene)?, scene.clone(), Model::default());
        let (partners, last) = (partners(model), [f32::NAN; MOST]);
        Ok(Self { of, scene, play, model, partners, still: false, cut: false, restarts: 0, last })
    }

    fn anew(&mut self) -> Result<(), Failure> {
        self.play = (self.of.open)(&self.scene)?;
        self.partners = partners(self.model);
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

/// Of the first two hands this model, at rest.
fn partners(model: Model) -> [Partner; 2 + THERE.len()] {
    let [three, four] = THERE;
    [model, model, three, four].map(Partner::new)
}

impl Environment for SharedEnvironment {
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
                self.partners[..2].fill(Partner::new(model));
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
            let Route { delay_ns, rule, .. } = route(&self.scene, from, to);
            let route = self.play.route(from, to);
            (route.delay_ns, route.rule) = (delay_ns, rule);
        }
        Ok(())
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32) {
        let at = at.filter(|_| restarts == self.restarts);
        self.partners[hand].rest();
        self.play.hold(hand, at.map_or(Held::Free, |[along, across, _]| Held::At([along, across])));
    }

    fn play(&mut self, hand: usize) {
        let held = match self.play.device(hand) {
            Some(at) => self.partners[hand].wants([at], PERIOD_S).map_or(Held::Free, |[at]| Held::At([at, 0.0])),
            None => Held::ByNobody,
        };
        self.play.hold(hand, held);
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        if self.still {
            return Ok(self.last);
        }
        if self.play.is_over() {
            self.anew()?;
        }
        let others = 2..self.partners.len();
        for hand in others.take_while(|hand| self.play.device(*hand).is_some()).collect::<Vec<_>>() {
            Environment::play(self, hand);
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
        let modes = if self.still { [OFF; 2] } else { self.play.modes().map(number_of) };
        Standing { modes, cut: self.cut, partner: self.model.number() }
    }
}
