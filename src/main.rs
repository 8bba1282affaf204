//! The `radiosity` program: arguments in, exit status out.

use std::process::ExitCode;

use radiosity::cli;

fn main() -> ExitCode {
    cli::main()
}
