//! The `host-sim` command: see `host_sim::Cli`.

fn main() -> std::process::ExitCode {
    host_sim::Cli::default().main()
}
