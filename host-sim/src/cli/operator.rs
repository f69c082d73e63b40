//! `host-sim operator`: lines of text to a board, and its answers.

use std::io::BufRead;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;

use clap::Args;

use super::Failure;
use crate::live::operator::{Operator, PORT};

/// Arguments of `operator`.
#[derive(Debug, Args)]
pub(super) struct Operate {
    /// The board's address; its port is 7702 unless another is given.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = board)]
    board: SocketAddr,
    /// The key file that the board was provisioned with.
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// What to say, one line each, in quotes; stops at the first that the board refuses. Without any: lines are read from
    /// standard input, and answered one by one.
    #[arg(value_name = "LINE")]
    lines: Vec<String>,
}

/// An address with or without a port.
pub(super) fn board(text: &str) -> Result<SocketAddr, String> {
    let address = text.parse::<IpAddr>().map(|address| SocketAddr::new(address, PORT));
    address.or_else(|_| text.parse()).map_err(|_| format!("{text} is no address: it must be like 192.168.77.1"))
}

impl Operate {
    /// Says the lines and prints the answers.
    ///
    /// # Errors
    /// Nobody there, or a line that the board refuses.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let mut operator = Operator::connect(self.board, &self.key_file)?;
        for line in &self.lines {
            let answer = operator.ask(line)?;
            if let Some(why) = answer.strip_prefix("error ") {
                return Err(format!("board {}: {line}: {why}", operator.number()).into());
            }
            println!("{answer}");
        }
        if self.lines.is_empty() {
            for line in std::io::stdin().lock().lines() {
                println!("{}", operator.ask(line?.trim())?);
            }
        }
        Ok(())
    }
}
