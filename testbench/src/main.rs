//! The command `pellucid`.

use pellucid_testbench::command;
use std::process::ExitCode;

fn main() -> ExitCode {
    command::main()
}
