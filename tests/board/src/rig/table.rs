//! Two boards on a table: that under test over the network, as cohold's operator; the rig over the serial port of its ST-LINK; and the probe
//! of the board under test.

use std::net::SocketAddr;
use std::path::Path;
use std::time::{Duration, Instant};

use cohold_live::operator::Operator;
use cohold_rig::run::{Boards, Came, Done, Outcome};
use firmware_parts::record::{CODE, Record};

use super::openocd::{self, Probe};
use super::port::Port;
use super::stop::{self, Records};
use super::told;

/// Between two looks at what has come, ms.
const LOOK_MS: u64 = 5;
/// How long the probe may take, and a board to start anew.
const PROBING: Duration = Duration::from_secs(20);
const STARTING: Duration = Duration::from_secs(30);

/// Both boards, and the probe.
pub struct Table {
    operator: Operator,
    port: Port,
    probe: Box<dyn Probe>,
    /// Since the board was armed last.
    records: Vec<Record>,
}

impl Table {
    /// Gets in touch with the board at this address under the operator's key of a file, and with the rig at this port.
    ///
    /// # Errors
    /// One of them is not there.
    pub fn connect(board: SocketAddr, key: &Path, port: &Path, probe: Box<dyn Probe>) -> Result<Self, String> {
        let port = Port::open(port)?;
        let operator = Operator::connect(board, key).map_err(|why| why.to_string())?;
        Ok(Self { operator, port, probe, records: Vec::new() })
    }

    /// Until the board has told of so many ticks more, by its clock and not by the PC's.
    fn wait_ticks(&mut self, ticks: usize) -> Done {
        let (begun, before) = (Instant::now(), self.records.len());
        while self.records.len() < before + ticks && begun.elapsed() < PROBING {
            self.wait_ms(LOOK_MS)?;
        }
        Ok(())
    }

    /// The probe does something, and the board is kept meanwhile.
    fn probe(&mut self, commands: &str) -> Done {
        self.probe.begin(commands)?;
        let begun = Instant::now();
        while !self.probe.is_done()? {
            if begun.elapsed() > PROBING {
                return Err(format!("the probe does not end `{commands}` within {} s", PROBING.as_secs()));
            }
            self.wait_ms(LOOK_MS)?;
        }
        Ok(())
    }
}

impl Records for Table {
    fn take(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.records)
    }
}

impl Boards for Table {
    fn ask(&mut self, line: &str) -> Outcome {
        if line.starts_with("arm") {
            self.records.clear();
        }
        self.operator.ask(line).map_err(|why| why.to_string())
    }

    fn order(&mut self, line: &str) -> Done {
        self.port.say(line)
    }

    fn answer(&mut self, within_ms: u64) -> Outcome {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_millis(within_ms) {
            if let Some(line) = self.port.hear()? {
                return Ok(line);
            }
            self.wait_ms(LOOK_MS)?;
        }
        Err(format!("the rig does not answer within {within_ms} ms"))
    }

    fn wait_ms(&mut self, ms: u64) -> Done {
        let samples = self.operator.samples(Duration::from_millis(ms)).map_err(|why| why.to_string())?;
        let first = samples.iter().filter(|sample| sample.code == CODE);
        self.records.extend(first.filter_map(|sample| Record::from_bytes(sample.payload())));
        Ok(())
    }

    fn probing_ms(&self) -> u64 {
        PROBING.as_millis() as u64
    }

    fn stop_ticks(&mut self) -> Done {
        self.probe(&openocd::stop_ticks())
    }

    fn halt(&mut self, ms: u64) -> Done {
        self.probe(&openocd::halt(ms))
    }

    by_records! {}

    fn meet(&mut self) -> Done {
        let begun = Instant::now();
        loop {
            self.wait_ms(1300)?;
            match self.ask("status") {
                Ok(_) => return Ok(()),
                Err(why) if begun.elapsed() > STARTING => return Err(why),
                Err(_) => {}
            }
        }
    }

    fn counts(&mut self) -> Result<[u16; 2], String> {
        // A board that started anew has to be told again.
        self.ask("stream 1")?;
        self.wait_ticks(100)?;
        told::counts(&self.records)
    }

    fn same(&mut self, per_ms: u32) -> Result<[u64; 2], String> {
        self.wait_ticks(100)?;
        Ok(told::same(&self.records, per_ms))
    }
}
