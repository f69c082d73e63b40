//! The architectures paper's claims on systems: impulsive rendering (§2.1), what is static (§3.1), one at a time (§3.2), squash (§3.2.1),
//! and delays that are bought with stiffness or damping (§3.3).

use crate::records::{self, Bounds, Database, Object, Region, Scope, Shape};
use crate::roles::Role;
use crate::roles::squash::{Ball, Court, Message, Player, PlayerConfig, RALLIES, Turn};
use crate::roles::static_scene::{Download, Roam, Server};
use crate::squash::{self, Cell, Options, Report};
use cohold_analysis::rendering::identify::{NETWORK, identify, wall};
use cohold_analysis::rendering::maps::{at, largest};
use cohold_core::contact::impact::{Body, advance};
use cohold_core::num::Motion;
use cohold_protocol::wire::PeerId;
use cohold_sim::rng::Rng;
use cohold_sim::scene::Network;
use cohold_studies::reproduce::{Claim, list, span};

use super::architectures::{Architecture, Row};
use cohold_studies::Error;

/// Random collisions.
const COLLISIONS: usize = 10_000;
/// Sampling periods of one stroke, s.
const PERIODS_S: [f64; 5] = [0.001, 0.005, 0.01, 0.02, 0.05];
/// What sums may be off by, relative.
const ROUNDING: f64 = 1e-12;
/// Seeds of the games, and a game's length, s.
const SEEDS: u64 = 4;
const GAME_S: f64 = 60.0;
/// Device of the last claim, kg.
const DEVICE_KG: f64 = 0.1;

/// All of them; `rows` are of every architecture at every delay.
pub(super) fn claims(rows: &[Row]) -> Result<Vec<Claim>, Error> {
    Ok([impulsive(), told(), vec![regions()?, overtaken()], turns(rows), game(), slow()?].concat())
}

/// A body on a line.
fn body(position: f64, velocity: f64, mass_kg: f64) -> Body<f64, 1> {
    Body { axes: [Motion::new(position, velocity)], radius: 0.05, inverse_mass: 1.0 / mass_kg }
}

fn momentum(bodies: &[Body<f64, 1>; 2]) -> f64 {
    bodies.iter().map(|body| body.axes[0].velocity / body.inverse_mass).sum()
}

fn impulsive() -> Vec<Claim> {
    let mut rng = Rng::new(1);
    let (mut hits, mut worst, mut pulse) = (0, 0.0_f64, 0.0_f64);
    for _ in 0..COLLISIONS {
        let [heavy, light] = [(); 2].map(|()| 0.05 * 100.0_f64.powf(rng.unit()));
        let mut bodies = [body(-0.2, 0.5 + 3.0 * rng.unit(), heavy), body(0.0, 2.0 * (rng.unit() - 0.8), light)];
        let start = bodies[0].axes[0].velocity;
        let before = (momentum(&bodies), bodies[0].energy_j() + bodies[1].energy_j());
        let account = advance(&mut bodies, &[], 1.0, 1.0);
        hits += account.impacts;
        let taken = bodies[0].axes[0].velocity - start;
        pulse = pulse.max((account.impulses[0][0] / (heavy * taken) - 1.0).abs());
        let after = (momentum(&bodies), bodies[0].energy_j() + bodies[1].energy_j());
        let size = (2.0 * before.1 * heavy.max(light)).sqrt();
        worst = worst.max((after.0 - before.0).abs() / size).max((after.1 / before.1 - 1.0).abs());
    }
    // One stroke, sampled more and more slowly, from the same start to the same end.
    let ends = PERIODS_S.map(|period_s| {
        let mut bodies = [body(-0.2, 3.0, 0.3), body(0.0, -0.5, 0.06)];
        let steps = (0.2 / period_s).round() as usize;
        for _ in 0..steps {
            advance(&mut bodies, &[], 1.0, period_s);
        }
        bodies.map(|body| body.axes[0].position)
    });
    let apart = ends.iter().flat_map(|end| [end[0] - ends[0][0], end[1] - ends[0][1]]);
    let apart = apart.map(f64::abs).fold(0.0, f64::max);
    // A body that is pushed against another one, 5 N for 2 s, without loss at impacts and with: how many there are, and whether it rests.
    let pushed = [1.0, 0.5].map(|restitution| {
        let mut bodies = [body(-0.2, 0.0, 0.3), Body { inverse_mass: 0.0, ..body(0.0, 0.0, 1.0) }];
        let (mut impacts, mut stood_s) = (0, 0.0);
        for _ in 0..2000 {
            bodies[0].axes[0].velocity += 0.001 * 5.0 / 0.3;
            let account = advance(&mut bodies, &[], restitution, 0.001);
            impacts += account.impacts;
            stood_s += account.stood_s;
        }
        (impacts, stood_s)
    });
    let [(elastic, _), (lossy, stood_s)] = pushed;
    vec![
        Claim::holds(
            "§2.1, eq. 3",
            "In an elastic collision energy and momentum are the same before and after",
            hits as usize == COLLISIONS && worst < ROUNDING,
            format!("{hits} of {COLLISIONS} random collisions found; off by {worst:.1e} at most"),
        ),
        Claim::holds(
            "§2.1, eq. 4",
            "The impulse ΔQ that the hand is to feel is the momentum that its racket took",
            pulse < ROUNDING,
            format!("off by {pulse:.1e} of it at most in the same collisions"),
        ),
        Claim::holds(
            "§2.1",
            "Impulsive rendering need not run at a high sampling rate",
            apart < ROUNDING,
            format!(
                "a stroke at {} Hz and at {} Hz ends {apart:.1e} m apart at most",
                1.0 / PERIODS_S[0],
                1.0 / PERIODS_S[4]
            ),
        )
        .but("of what the bodies do; the pulse that the hand feels is as long as a period"),
        Claim::holds(
            "§2.1",
            "Impulsive rendering does not work for extended contact",
            elastic > 1 && lossy > 1000,
            format!(
                "a body pushed against a wall with 5 N for 2 s hits it {elastic} times and never rests; with half of the speed given back {lossy} times, and is held still by force for {stood_s:.2} s"
            ),
        ),
    ]
}

fn of(rows: &[Row], architecture: Architecture) -> impl Iterator<Item = &Row> + Clone {
    rows.iter().filter(move |row| row.architecture == architecture)
}

/// §3.1: a client that walks through two regions, each of a server of its own, and back.
fn regions() -> Result<Claim, Error> {
    const BODIES: usize = 40;
    const MARGIN_M: f32 = 5.0;
    let mut world = Database::<BODIES>::default();
    (world.version, world.margin_m) = (1, MARGIN_M);
    let body = |id| records::Body { x_m: id as f32, radius_m: 0.5, ..records::Body::default() };
    let object = |id| Object { id, version: 1, shape: Shape::Body(body(id)) };
    (0..BODIES as u32).try_for_each(|id| world.put(object(id))).map_err(|full| full.to_string())?;
    for (id, from, to) in [(0, -1.0, 20.0), (1, 20.0, 41.0)] {
        let bounds = Bounds { min: [from, -1.0], max: [to, 1.0] };
        world.put_region(Region { id, server: id, bounds }).map_err(|full| full.to_string())?;
    }
    let server = |region| Server::new(world.clone(), Some(region)).map_err(|error| error.to_string());
    let servers = [server(0)?, server(1)?];
    let (mut downloads, mut roam) = ([(); 2].map(|()| Download::<BODIES>::default()), Roam::new(0));
    let (mut held, mut touched) = (0, 0);
    // From 10 m to 30 m and back at 1 m/s, asking each 8 ms.
    let steps = 5_000;
    for step in 0..steps {
        let x = 30.0 - 20.0 * (2.0 * step as f32 / steps as f32 - 1.0).abs();
        for server in roam.needs(world.regions(), MARGIN_M, [x, 0.0]) {
            let (server, download) = (&servers[usize::from(server)], &mut downloads[usize::from(server)]);
            download.look(Scope::Around { x: (2.0 * x).round() / 2.0, y: 0.0, radius: 2.0 });
            if let Some(ask) = download.poll(8_000 * (1 + step as u64), 100_000) {
                server.answer(&ask).for_each(|part| _ = download.take(&part));
            }
        }
        roam.update(world.regions(), [x, 0.0], |server| downloads[usize::from(server)].is_complete());
        let home = &downloads[usize::from(roam.home())];
        // What it touches; the first seconds are those of the first download.
        for object in world.objects().iter().filter(|object| step > 100 && (object.id as f32 - x).abs() < 0.5) {
            touched += 1;
            held += u32::from(home.objects().any(|known| known == object));
        }
    }
    let moves = roam.moves();
    Ok(Claim::holds(
        "§3.1",
        "A world may be split over servers by region, and clients migrate between them",
        held == touched && touched > 0 && (roam.home(), moves) == (0, 2),
        format!(
            "a client that walks through two regions and back moves {moves} times; what it touches its server holds in {held} of {touched} instants"
        ),
    ))
}

/// What no run here can tell, of §2 and §3.2.
fn told() -> Vec<Claim> {
    vec![
        Claim::not_testable(
            "§2",
            "Graphics and haptics run in loops of their own",
            "so it is here: the control loop hands its rows on, and waits for no page, picture or file".to_owned(),
            "how a program is built, without a number",
        ),
        Claim::not_testable(
            "§3.2",
            "News are there sooner from peer to peer than by a server",
            "counted, a way by a server is two transmissions and a straight one is one".to_owned(),
            "a straight way is never longer, but delays of real routes need not grow with the way, and none is given",
        ),
    ]
}

/// §3.2.1: positions of another player in a random order.
fn overtaken() -> Claim {
    let config = PlayerConfig { number: PeerId(1), court: Court::SINGLES, ball_kg: 0.024, life: 1 };
    let (mut player, mut rng) = (Player::new(config), Rng::new(1));
    let (mut newest, mut late, mut kept) = (0, 0, 0);
    for _ in 0..COLLISIONS {
        let number = 1 + rng.below(COLLISIONS as u64) as u32;
        let racket = Ball { position: [number as f32, 0.0], velocity: [0.0; 2] };
        let place = Message::Place { turn: Turn::default(), revision: 0, life: 1, number, round_trip_us: 0, racket };
        player.receive(0, PeerId(2), &place, &mut |_, _| {});
        late += u32::from(number < newest);
        newest = number.max(newest);
        kept += usize::from(player.racket_of(PeerId(2)).is_some_and(|racket| racket.position[0] == newest as f32));
    }
    Claim::holds(
        "§3.2.1",
        "Packets of a flow that come out of order are dropped",
        kept == COLLISIONS && late > 0,
        format!(
            "of {COLLISIONS} positions in a random order {late} came after a newer one; the newest stood in {kept}"
        ),
    )
}

/// Claims of §3.1 and §3.2 on delay and load.
fn turns(rows: &[Row]) -> Vec<Claim> {
    let local = of(rows, Architecture::Static);
    let [least, most] = span(local.clone().map(|row| row.peak_n));
    let stable = local.clone().filter(|row| row.stable).count();
    let longest = rows.iter().map(|row| row.delay_ms).fold(0.0, f64::max);
    let mut claims = vec![Claim::holds(
        "§3.1",
        "A static environment works well for any delay",
        stable == local.clone().count() && most - least <= ROUNDING * most,
        format!(
            "{stable} of {} delays up to {longest} ms stable, what a hand feels at most {least:.4} to {most:.4} N",
            local.count()
        ),
    )];
    for (name, architecture) in
        [("a central server", Architecture::CollaborativeLock), ("a token ring", Architecture::CollaborativeRing)]
    {
        let stable = of(rows, architecture).filter(|row| row.stable).count();
        let here = of(rows, architecture).count();
        claims.push(
            Claim::in_places(
                "§3.2",
                &format!("One at a time, by {name}, copes with large delay: the haptic loop is local"),
                stable,
                here,
                format!("{stable} of {here} delays up to {longest} ms stable"),
            )
            .but("a turn waits for the network: how long is in the table of architectures"),
        );
    }
    // Each of n says where it is, and everybody hears it: counted, as the paper does.
    let users = [2, 4, 8, 16, 32];
    let (served, between): (Vec<usize>, Vec<usize>) = users.iter().map(|n| (n + n * (n - 1), 2 * (n - 1))).unzip();
    let ratio = |at: usize| served[at] as f64 / between[at] as f64;
    claims.push(Claim::holds(
        "§3.2",
        "A server is loaded by all that is said as users become more; from peer to peer the load is spread",
        (1..users.len()).all(|at| ratio(at) > ratio(at - 1)),
        format!("messages that the busiest handles while each of {users:?} users speaks once: {served:?} at a server, {between:?} from peer to peer"),
    ).but("counted, not measured: both send every user the same"));
    claims
}

/// Claims of §3.2.1, by games between bots.
fn game() -> Vec<Claim> {
    let options = Options {
        players: 4,
        round_trip_s: 0.0,
        network: Network::default(),
        bounder: true,
        motion_bounder: true,
        seconds: GAME_S,
        rallies: RALLIES,
        seed: 1,
        changes: Vec::new(),
        record_every: 0,
    };
    let games: Vec<Vec<Cell>> = (1..=SEEDS).map(|seed| squash::sweep(&Options { seed, ..options.clone() })).collect();
    let trips = squash::ROUND_TRIPS_MS;
    // Over all seeds, by round trip.
    let over = |bounder: &'static str, of: fn(&Report) -> f64, join: fn(f64, f64) -> f64| -> Vec<f64> {
        let at = |ms: f64| {
            let here = games.iter().flatten().filter(|cell| cell.bounder == bounder && cell.round_trip_ms == ms);
            here.map(|cell| of(&cell.report)).fold(0.0, join)
        };
        trips.map(at).to_vec()
    };
    let court_m = f64::from(Court::SINGLES.length_m);
    let farthest = |bounder| over(bounder, |report| report.farthest_before_news_m, f64::max);
    let [free, bounded] = [farthest("none"), farthest("ball")];
    let kept = bounded.iter().filter(|m| **m <= court_m).count();
    let left = over("none", |report| f64::from(report.left_the_court), |sum, one| sum + one);
    let travel = |bounder| over(bounder, |report| report.hand_travel_m, f64::max);
    let [quick, damped] = [travel("ball"), travel("ball+motion")];
    let slower = quick.iter().zip(&damped).filter(|(quick, damped)| damped <= quick).count();
    vec![
        Claim::in_places(
            "§3.2.1",
            "The adaptive dynamic bounder keeps the ball from flying further than the court within the delay",
            kept,
            bounded.len(),
            format!(
                "{} m at most before the news came, at {trips:?} ms round trip; {} m without; the court has {court_m} m",
                list(&bounded),
                list(&free)
            ),
        ),
        Claim::holds(
            "§3.2.1",
            "The longer the delay, the more often the ball has left the court before the next player knows",
            left.windows(2).all(|pair| pair[1] >= pair[0]) && left.last() > left.first(),
            format!(
                "{} times in {SEEDS} games of {GAME_S} s without the bounder, at {trips:?} ms",
                left.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
            ),
        ),
        Claim::in_places(
            "§3.2.1",
            "Damping in proportion to the delay limits how fast a user moves (proposed there, not built)",
            slower,
            quick.len(),
            format!("a hand's way in a round trip {} m at most, {} m without", list(&damped), list(&quick)),
        ),
    ]
}

/// §3.3: 50 to 100 ms.
fn slow() -> Result<Vec<Claim>, Error> {
    let device = identify(DEVICE_KG)?;
    let limits = |damping: f64| -> Result<Vec<f64>, Error> {
        [0.05, 0.1]
            .map(|delay_s| {
                Ok(largest(&at(&wall(device.mass_kg, damping, device.computing_ticks), NETWORK, delay_s, None))?)
            })
            .into_iter()
            .collect()
    };
    let (own, more) = (limits(device.damping_n_s_per_m)?, limits(4.0 * device.damping_n_s_per_m)?);
    let list = |values: &[f64]| list(values).replace(", ", " and ");
    Ok(vec![
        Claim::holds(
            "§3.3",
            "50 to 100 ms are manageable with a softer object, or with artificial damping",
            own.iter().all(|limit| *limit > 0.0) && own.iter().zip(&more).all(|(own, more)| more > own),
            format!(
                "a wall's largest stiffness at 50 and 100 ms is {} N/m; {} N/m with four times the damping: some at both, and more the more damping",
                list(&own),
                list(&more)
            ),
        )
        .but(format!("of the device of {DEVICE_KG} kg that the paper's 200 Hz and 5 ms imply: what is left is soft")),
    ])
}
