//! The `cohold` command: see `cohold::command_line`.

fn main() -> std::process::ExitCode {
    cohold::command_line().main()
}
