//! The command `pellucid`, whose code is a library so that it is compiled while the crates below it still are.

use std::process::ExitCode;

fn main() -> ExitCode {
    pellucid::main()
}
