//! The command `qrm`.

use std::process::ExitCode;

fn main() -> ExitCode {
    qrm::main()
}
