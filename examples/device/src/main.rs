//! A device of your own at a live peer: a handle behind a TCP line. It takes `FORCE` (N) a line, or `?`, answers each with `PLACE SPEED FORCE`
//! (m, m/s, N), and lets go after 20 ms without one. `cargo run -- devices --device handle:127.0.0.1:7000` tries it; `peer` drives it.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use cohold_live::Error;
use cohold_live::devices::{AXES, Abilities, DeviceOptions, Gone, Port, Sensed, Settings, stopped};

struct Handle {
    abilities: Abilities,
    line: BufReader<TcpStream>,
    text: String,
    asked: VecDeque<Instant>,
    newest: Option<(Sensed, f64)>,
}

fn open(at: &str, _: &DeviceOptions, _: &Settings) -> Result<Box<dyn Port>, Error> {
    let line = TcpStream::connect(at).map_err(|cause| format!("the handle at {at}: {cause}"))?;
    line.set_nonblocking(true).and_then(|()| line.set_nodelay(true)).map_err(|cause| cause.to_string())?;
    let (name, lets_go_s, max_force_n) = (format!("handle at {at}"), Some(0.02), Some(5.0));
    let abilities = Abilities { name, axes: 1, max_force_n, is_homed: true, lets_go_s, ..Abilities::default() };
    Ok(Box::new(Handle { abilities, line: BufReader::new(line), text: String::new(), asked: [].into(), newest: None }))
}

impl Port for Handle {
    fn abilities(&self) -> &Abilities {
        &self.abilities
    }
    fn read(&mut self) -> Result<Option<Sensed>, Gone> {
        while let Ok(length) = self.line.read_line(&mut self.text) {
            let text = std::mem::take(&mut self.text);
            let numbers: Vec<f64> = text.split(' ').filter_map(|word| word.trim().parse().ok()).collect();
            let (Some(asked), &[place, speed, force]) = (self.asked.pop_front(), &numbers[..]) else {
                return Err(stopped(if length == 0 { "it has closed the line" } else { "it says no three numbers" }));
            };
            let (between, position_m, velocity_m_per_s) =
                ([asked, Instant::now()], [place, 0.0, 0.0], [speed, 0.0, 0.0]);
            self.newest = Some((Sensed { position_m, velocity_m_per_s, between, buttons: 0 }, force));
        }
        Ok(self.newest.map(|(sensed, _)| sensed))
    }
    fn write(&mut self, force_n: Option<[f64; AXES]>) {
        self.asked.push_back(Instant::now());
        let _ = writeln!(self.line.get_mut(), "{:.5}", force_n.unwrap_or_default()[0]);
    }
    fn stay_silent(&mut self, time: Duration) -> Result<Option<f64>, Gone> {
        std::thread::sleep(time);
        self.asked.push_back(Instant::now());
        writeln!(self.line.get_mut(), "?").map_err(stopped)?;
        std::thread::sleep(Duration::from_millis(20));
        self.read().map(|_| self.newest.map(|(_, force)| force.abs()))
    }
}

fn main() -> std::process::ExitCode {
    cohold::command_line().with_device("handle", open).main()
}
