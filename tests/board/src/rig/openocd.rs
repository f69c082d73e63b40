//! The probe of the board under test, by OpenOCD: it writes into a running chip without halting it, and leaves the counter of cycles on.
//! probe-rs halts the processor for a moment whenever it attaches and detaches (probe-rs/src/session.rs), which is what is measured here.

use std::process::{Child, Command, Stdio};

/// TIM6_CR1, and a timer that does not run.
pub const TICK_STANDS: (u64, u32) = (0x4000_1000, 0);

/// Takes commands as OpenOCD's.
pub trait Probe {
    /// Begins to carry commands out.
    ///
    /// # Errors
    /// It cannot.
    fn begin(&mut self, commands: &str) -> Result<(), String>;

    /// Whether what was begun last has been done.
    ///
    /// # Errors
    /// It failed.
    fn is_done(&mut self) -> Result<bool, String>;
}

/// What stops the tick's timer.
pub fn stop_ticks() -> String {
    let (address, word) = TICK_STANDS;
    format!("mww {address:#x} {word}")
}

/// What halts the processor for so long.
pub fn halt(ms: u64) -> String {
    format!("halt; sleep {ms}; resume")
}

/// OpenOCD on an ST-LINK of this serial number.
#[derive(Debug)]
pub struct OpenOcd {
    serial: String,
    running: Option<Child>,
}

impl OpenOcd {
    /// On this probe.
    pub fn new(serial: &str) -> Self {
        Self { serial: serial.to_owned(), running: None }
    }

    /// What carries commands out.
    fn command(&self, commands: &str) -> Command {
        let mut command = Command::new("openocd");
        command.args(["-f", "board/st_nucleo_h743zi.cfg", "-c", &format!("adapter serial {}", self.serial)]);
        command.args(["-c", &format!("init; {commands}; shutdown")]);
        command
    }
}

impl Probe for OpenOcd {
    fn begin(&mut self, commands: &str) -> Result<(), String> {
        let mut command = self.command(commands);
        let begun = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        self.running = Some(begun.map_err(|cause| format!("cannot run openocd: {cause}"))?);
        Ok(())
    }

    fn is_done(&mut self) -> Result<bool, String> {
        let failed = |cause: std::io::Error| format!("openocd: {cause}");
        let Some(running) = &mut self.running else { return Ok(true) };
        if running.try_wait().map_err(failed)?.is_none() {
            return Ok(false);
        }
        let Some(output) = self.running.take().map(Child::wait_with_output).transpose().map_err(failed)? else {
            return Ok(true);
        };
        let told = String::from_utf8_lossy(&output.stderr);
        // What fails in a command of its own leaves the exit status as it is.
        match told.lines().find(|line| line.starts_with("Error: ")) {
            None if output.status.success() => Ok(true),
            told => Err(format!("openocd on {}: {}", self.serial, told.unwrap_or("it failed, and does not say why"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_openocd_is_told() {
        let command = OpenOcd::new("0042").command(&stop_ticks());
        let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
        assert_eq!(
            words,
            ["-f", "board/st_nucleo_h743zi.cfg", "-c", "adapter serial 0042", "-c", "init; mww 0x40001000 0; shutdown"]
        );
        assert_eq!(halt(5), "halt; sleep 5; resume");
    }
}
