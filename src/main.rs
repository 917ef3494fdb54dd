//! The command `cvr`.

use std::process::ExitCode;

fn main() -> ExitCode {
    cvr::cli::main()
}
