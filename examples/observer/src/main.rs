//! An observer of your own: what one hand feels over how deep it presses, a loop for every push, drawn as a figure.
//!
//! A run is stepped and watched from outside: `Pair::step_watched` tells what every tick of either peer read and did.
//! Leaves `out/felt.svg`, `out/felt.pdf` and `out/felt.png` in the folder that it runs in.

use std::error::Error;
use std::path::Path;

use cohold_plot::{Figure, Panel, Series, draw};
use cohold_sim::{Laws, Pair, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    // Two users push against each other: one steadily, the other one like a sine.
    let set = ["user.1.push_n=1", "user.2.push_n=1", "user.1.sine_n=0.5", "user.1.sine_rad_per_s=6"];
    let scene = Scene::load(Laws::built_in(), None, &set.map(str::to_owned))?;
    let mut pair = Pair::<f64>::new(&scene)?;
    let mut felt: [Vec<(f64, f64)>; 2] = Default::default();
    while pair.time_s() < 5.0 {
        pair.step_watched(&mut |seen| {
            let now = seen.peer.observed()[0];
            let depth_mm = 1e3 * (now.device.position - now.object.position).abs();
            felt[seen.number - 1].push((depth_mm, now.contact_force.abs()));
        });
    }
    let line = |(at, points)| Series::line(format!("user {}", at + 1), at, points);
    let panel = Panel {
        x_label: "Depth (mm)".to_owned(),
        y_label: "Contact force (N)".to_owned(),
        series: felt.into_iter().enumerate().map(line).collect(),
        ..Panel::default()
    };
    let figure = Figure { title: "What each hand feels".to_owned(), panels: vec![panel], ..Figure::default() };
    for file in draw(&figure, Path::new("out/felt"))? {
        println!("wrote {}", file.display());
    }
    Ok(())
}
