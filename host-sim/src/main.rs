//! The `host-sim` command: see `host_sim::command_line`.

fn main() -> std::process::ExitCode {
    host_sim::command_line().main()
}
