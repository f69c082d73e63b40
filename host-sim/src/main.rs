//! The `host-sim` command: see [`host_sim::cli`].

fn main() -> std::process::ExitCode {
    host_sim::Cli::default().main()
}
