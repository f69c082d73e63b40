//! Laws from the literature: the lifted matrix that is driven from core beside a dense one that is written down here from the papers' equations.
//!
//! Peers are alike, so that the pair falls apart into what both do alike and what they do against each other; in either the other peer's packet is ± the
//! own one of n_t periods ago. A tick is its equations as a linear system in what belongs to the tick (mean velocities, forces), solved by elimination; a
//! period is M of them. What is compared are the traces of powers, tr(A^k) = Σλ^k: they know every eigenvalue with its multiplicity, rest modes included,
//! and states that are written over before they are read count nothing.

use cohold_analysis::{Matrix, pair_matrix};
use cohold_core::law::wave::Decode;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;

use crate::random::Random;

/// Dense, row by row.
type Dense = Vec<Vec<f64>>;

fn times(a: &Dense, b: &Dense) -> Dense {
    a.iter()
        .map(|row| (0..b[0].len()).map(|j| row.iter().zip(b).map(|(x, other)| x * other[j]).sum()).collect())
        .collect()
}

/// tr(A^k) for k = 1…`count`.
fn traces(a: &Dense, count: usize) -> Vec<f64> {
    let mut power = a.clone();
    (0..count)
        .map(|_| {
            let trace = (0..a.len()).map(|i| power[i][i]).sum();
            power = times(&power, a);
            trace
        })
        .collect()
}

/// x of A·x = b, by elimination with pivots.
fn solve(mut a: Dense, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|i, j| a[*i][column].abs().total_cmp(&a[*j][column].abs())).unwrap();
        a.swap(column, pivot);
        b.swap(column, pivot);
        for row in 0..n {
            if row != column {
                let above = a[column].clone();
                let share = a[row][column] / above[column];
                for (element, above) in a[row].iter_mut().zip(above) {
                    *element -= share * above;
                }
                b[row] -= share * b[column];
            }
        }
    }
    (0..n).map(|at| b[at] / a[at][at]).collect()
}

/// What all laws have: device, contact, object, spring.
#[derive(Clone, Copy, Debug)]
struct Body {
    period: f64,
    ticks: usize,
    delay: usize,
    device: [f64; 2],
    contact: [f64; 2],
    object: [f64; 2],
    spring: [f64; 2],
}

/// What a tick does to all states, from the packet that stands; true in the first tick after it came.
type PaperTick = Box<dyn Fn(Body, &[f64], &[f64; 3], bool) -> Vec<f64>>;

/// A law: states of its own beside x_h, ẋ_h, x_o, ẋ_o; and what a tick does to all of them, with the packet that stands.
struct Paper {
    own: usize,
    tick: PaperTick,
    /// Position, velocity and force that are sent.
    sent: fn(&[f64]) -> [f64; 3],
}

impl Body {
    /// Device (exact, its force held), with F_LC.
    fn device(&self, y: &[f64], contact: f64) -> [f64; 2] {
        let [mass, damping] = self.device;
        let keep = (-damping * self.period / mass).exp();
        let (rise, way) = ((1.0 - keep) / damping, mass / damping * (1.0 - keep));
        [y[0] + way * y[1] - (self.period - way) / damping * contact, keep * y[1] - rise * contact]
    }

    /// The equations that every law shares, in the unknowns v̄ (mean velocity of the copy) and F_LC, with F_T the unknown `coordination` of `n`:
    /// (2m/T_c)·(v̄ − ẋ_o) + b·v̄ = F_LC + F_T, F_LC = K·(x_h − x_o − T_c/2·v̄) + B·(ẋ_h − v̄).
    fn shared(&self, y: &[f64], n: usize, coordination: usize) -> (Dense, Vec<f64>) {
        let ([mass, damping], [k, b]) = (self.object, self.contact);
        let (mut a, mut right) = (vec![vec![0.0; n]; n], vec![0.0; n]);
        let inertia = 2.0 * mass / self.period;
        (a[0][0], a[0][1], a[0][coordination], right[0]) = (inertia + damping, -1.0, -1.0, inertia * y[3]);
        (a[1][0], a[1][1], right[1]) = (k * self.period / 2.0 + b, 1.0, k * (y[0] - y[2]) + b * y[1]);
        (a, right)
    }

    /// Device and copy after the tick.
    fn moved(&self, y: &[f64], mean: f64, contact: f64) -> Vec<f64> {
        let [x_h, v_h] = self.device(y, contact);
        vec![x_h, v_h, y[2] + self.period * mean, 2.0 * mean - y[3]]
    }

    /// One packet period of a peer whose other one does `sign` times the same.
    fn lifted(&self, paper: &Paper, sign: f64) -> Dense {
        let (own, flying) = (4 + paper.own, 3 * self.delay);
        let column = |unit: usize| {
            let mut whole = vec![0.0; own + flying];
            whole[unit] = 1.0;
            let sent = (paper.sent)(&whole[..own]);
            // Packets under way, the oldest first; without delay the one that is sent stands at once.
            let mut packets: Vec<[f64; 3]> =
                whole[own..].chunks(3).map(|three| [three[0], three[1], three[2]]).collect();
            packets.push(sent);
            let stands = packets.remove(0).map(|number| sign * number);
            let mut y = whole[..own].to_vec();
            for tick in 0..self.ticks {
                y = (paper.tick)(*self, &y, &stands, tick == 0);
            }
            y.extend(packets.into_iter().flatten());
            y
        };
        let columns: Vec<Vec<f64>> = (0..own + flying).map(column).collect();
        (0..own + flying).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }
}

/// F_T = C·(x_r − x_o) + λ·F_r + μ·F_LC(the tick before) − d·v̄; F_LC is remembered.
fn four_channel(remote: f64, local: f64, ground: f64) -> Paper {
    Paper {
        own: 1,
        tick: Box::new(move |body, y, packet, _| {
            let [k, b] = body.spring;
            let (mut a, mut right) = body.shared(y, 3, 2);
            (a[2][0], a[2][2]) = (k * body.period / 2.0 + b + ground, 1.0);
            right[2] = k * (packet[0] - y[2]) + b * packet[1] + remote * packet[2] + local * y[4];
            let tick = solve(a, right);
            [body.moved(y, tick[0], tick[1]), vec![tick[1]]].concat()
        }),
        sent: |y| [y[2], y[3], y[4]],
    }
}

/// F_T = K·(x_r − x_o) − B·v̄.
fn p_plus_d() -> Paper {
    Paper {
        own: 0,
        tick: Box::new(|body, y, packet, _| {
            let [k, b] = body.spring;
            let (mut a, mut right) = body.shared(y, 3, 2);
            (a[2][0], a[2][2], right[2]) = (k * body.period / 2.0 + b, 1.0, k * (packet[0] - y[2]));
            let tick = solve(a, right);
            body.moved(y, tick[0], tick[1])
        }),
        sent: |y| [y[2], 0.0, 0.0],
    }
}

/// F_T = C·(x̄ − x_o), x̄ of the first tick after a packet; x̄ is remembered.
fn average_position() -> Paper {
    Paper {
        own: 2,
        tick: Box::new(|body, y, packet, came| {
            let [k, b] = body.spring;
            let mean = if came { [(y[2] + packet[0]) / 2.0, (y[3] + packet[1]) / 2.0] } else { [y[4], y[5]] };
            let (mut a, mut right) = body.shared(y, 3, 2);
            (a[2][0], a[2][2], right[2]) = (k * body.period / 2.0 + b, 1.0, k * (mean[0] - y[2]) + b * mean[1]);
            let tick = solve(a, right);
            [body.moved(y, tick[0], tick[1]), mean.to_vec()].concat()
        }),
        sent: |y| [y[2], y[3], 0.0],
    }
}

/// F_T = K·(x_p − x_o + T_c/2·(w − v̄)) + B·(w − v̄), (2m_p/T_c)·(w − ẋ_p) = K_p·(x_r − x_p − T_c/2·w) + B_p·(ẋ_r − w) − F_T.
fn remote_dynamic_proxy(mass: f64, stiffness: f64, damping: f64) -> Paper {
    Paper {
        own: 2,
        tick: Box::new(move |body, y, packet, _| {
            let ([k, b], half) = (body.spring, body.period / 2.0);
            let (mut a, mut right) = body.shared(y, 4, 2);
            (a[2][0], a[2][2], a[2][3], right[2]) = (k * half + b, 1.0, -(k * half + b), k * (y[4] - y[2]));
            (a[3][2], a[3][3]) = (1.0, mass / half + stiffness * half + damping);
            right[3] = mass / half * y[5] + stiffness * (packet[0] - y[4]) + damping * packet[1];
            let tick = solve(a, right);
            [body.moved(y, tick[0], tick[1]), vec![y[4] + body.period * tick[3], 2.0 * tick[3] - y[5]]].concat()
        }),
        sent: |y| [y[2], y[3], 0.0],
    }
}

/// As the proxy, with the copy's own mass and damping for the model's, nothing learned and everything covered:
/// (2m_O/T_c)·(w − ẋ_p) + b_O·w = K_c·(x_r − x_p − T_c/2·w) + B_c·(ẋ_r − w) − F_T.
fn model_mediated(stiffness: f64, damping: f64) -> Paper {
    Paper {
        own: 2,
        tick: Box::new(move |body, y, packet, came| {
            let [mass, own] = body.object;
            // Its own damping is one toward rest, which the proxy has not.
            let paper = remote_dynamic_proxy(mass, stiffness, damping + own);
            let toward = [packet[0], packet[1] * damping / (damping + own), packet[2]];
            (paper.tick)(body, y, &toward, came)
        }),
        sent: |y| [y[2], y[3], 0.0],
    }
}

/// A random pair of equal peers moved by ports, and what is needed of it here.
fn pair(random: &mut Random, law: &'static str, own: &[(&str, f64)]) -> (Scene, Body) {
    let mut scene = Scene::new(cohold_guest_laws::laws());
    let peer = &mut scene.peer;
    peer.object.integrator = IntegratorName::Midpoint;
    peer.object.force_delay_ticks = 0.0;
    peer.coordination.decode = Decode::Implicit;
    peer.coordination.comm = law;
    peer.timing.ticks_per_packet = random.whole(1, 8);
    peer.object.mass_kg = random.spread(0.1, 1.0);
    peer.object.damping_n_s_per_m = random.one(&[0.0, 0.7]);
    peer.contact.stiffness_n_per_m = random.spread(10.0, 1000.0);
    peer.contact.damping_n_s_per_m = random.spread(0.5, 5.0);
    peer.coordination.stiffness_n_per_m = random.spread(10.0, 3000.0);
    peer.coordination.damping_n_s_per_m = random.spread(0.5, 5.0);
    scene.world.device.force_delay_ticks = 0.0;
    scene.world.network.one_way_delay_packets = random.whole(0, 3);
    for (key, number) in own {
        scene.set_number(key, *number).expect("a key of the law");
    }
    let (peer, device) = (&scene.peer, &scene.world.device);
    let body = Body {
        period: peer.timing.control_period_s,
        ticks: peer.timing.ticks_per_packet as usize,
        delay: scene.world.network.one_way_delay_packets as usize,
        device: [device.mass_kg, device.damping_n_s_per_m],
        contact: [peer.contact.stiffness_n_per_m, peer.contact.damping_n_s_per_m],
        object: [peer.object.mass_kg, peer.object.damping_n_s_per_m],
        spring: [peer.coordination.stiffness_n_per_m, peer.coordination.damping_n_s_per_m],
    };
    (scene, body)
}

/// Traces of five powers, of 100 random pairs.
fn agree(law: &'static str, draw: impl Fn(&mut Random) -> (Vec<(&'static str, f64)>, Paper)) {
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let (own, paper) = draw(&mut random);
        let (scene, body) = pair(&mut random, law, &own);
        let [alike, against] = [1.0, -1.0].map(|sign| traces(&body.lifted(&paper, sign), 5));
        let driven = rows(&pair_matrix(&scene.linear()).expect("a linear scene").matrix);
        for (k, driven) in traces(&driven, 5).into_iter().enumerate() {
            let wanted = alike[k] + against[k];
            let scale = alike[k].abs() + against[k].abs() + 1.0;
            assert!(
                (driven - wanted).abs() < 1e-8 * scale,
                "{law}, pair {seed}, power {}: {driven}, {wanted} {body:?}",
                k + 1
            );
        }
    }
}

fn rows(matrix: &Matrix) -> Dense {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect()).collect()
}

#[test]
fn four_channel_is_the_paper_s() {
    agree("four-channel", |random| {
        let (remote, local) = (random.one(&[0.0, 0.5, 1.0, 2.0]), random.one(&[0.0, 0.0, -0.5, 1.0]));
        let ground = random.one(&[0.0, 0.0, 3.0, 40.0]);
        let own = vec![
            ("four_channel.remote_force", remote),
            ("four_channel.local_force", local),
            ("four_channel.local_damping_n_s_per_m", ground),
        ];
        (own, four_channel(remote, local, ground))
    });
}

#[test]
fn p_plus_d_is_the_paper_s() {
    agree("p-plus-d", |_| (Vec::new(), p_plus_d()));
}

#[test]
fn average_position_is_the_paper_s() {
    agree("average-position", |_| (Vec::new(), average_position()));
}

#[test]
fn remote_dynamic_proxy_is_the_paper_s() {
    agree("remote-dynamic-proxy", |random| {
        let (mass, stiffness, damping) = (random.spread(1e-3, 1.0), random.spread(1.0, 1e4), random.spread(0.1, 20.0));
        let own = vec![
            ("remote_proxy.mass_kg", mass),
            ("remote_proxy.stiffness_n_per_m", stiffness),
            ("remote_proxy.damping_n_s_per_m", damping),
        ];
        (own, remote_dynamic_proxy(mass, stiffness, damping))
    });
}

#[test]
fn model_mediated_is_the_paper_s_while_nothing_is_learned() {
    agree("model-mediated", |random| {
        let (stiffness, damping) = (random.spread(1.0, 1e4), random.spread(0.1, 20.0));
        let own = vec![
            ("coordination.tank_j", cohold_core::settings::PLENTY_J),
            ("model_mediated.correction_n_per_m", stiffness),
            ("model_mediated.correction_n_s_per_m", damping),
        ];
        (own, model_mediated(stiffness, damping))
    });
}
