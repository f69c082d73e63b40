//! The command line without any guest: `cargo run --package cohold-cli --example heart`.

fn main() -> std::process::ExitCode {
    cohold_cli::Cli::default().main()
}
