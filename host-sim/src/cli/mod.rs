//! The command line.
/// x
pub fn main() -> std::process::ExitCode { 
    let args: Vec<String> = std::env::args().skip(1).collect();
    let scene = crate::scene::SceneFile::load(None, &args).unwrap_or_else(|e| {eprintln!("{e}"); std::process::exit(2)});
    let t = std::time::Instant::now();
    let o = crate::experiment::run::<f64>(&scene, crate::experiment::Options{duration_s: 20.0, record_every: 0}, &|_| {}).unwrap();
    println!("{:?} {:?} true {} dec {} {:?} {} {:?} {:?}", o.bounded, o.fault, o.true_discrepancy_mm, o.decoded_discrepancy_mm, o.coordination_force_n, o.ticks, t.elapsed(), o.energy);
    println!("mass {:?}", crate::experiment::apparent_mass::measure(&scene));
    std::process::ExitCode::SUCCESS }
