//! Tools and files from outside, which a user's machine may lack.

use std::path::Path;
use std::process::Command;

/// Whether all of these are there: commands, and folders by their full path. Where they must be, as on a build machine, a
/// missing one is a failure; else the reason is printed and the test passes over what needs them.
pub fn have(tools: &[&str]) -> bool {
    let required = std::env::var_os("PELLUCID_REQUIRE_TOOLS").is_some();
    for tool in tools {
        let path = Path::new(tool);
        let found = match path.is_absolute() {
            true => path.is_dir(),
            false => Command::new(tool).arg("--help").output().is_ok(),
        };
        assert!(found || !required, "`{tool}` is required here and missing");
        if !found {
            println!("skipped: `{tool}` is not installed");
            return false;
        }
    }
    true
}
