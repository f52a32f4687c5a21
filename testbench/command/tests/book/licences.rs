//! What we stand on may be used as our own licence says: the licences of all dependencies are among those that
//! `deny.toml` allows.

use super::page::{root, text_of};
use serde_json::Value;
use spdx::{Expression, LicenseItem, ParseMode};
use std::process::Command;

fn said(command: &mut Command) -> String {
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn every_dependency_has_a_licence_that_is_allowed() {
    let policy: toml::Table = text_of(&root().join("deny.toml")).parse().unwrap();
    let allowed: Vec<&str> = policy["licenses"]["allow"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    let compiler = said(Command::new("rustc").arg("-vV"));
    let host = compiler.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let metadata = said(
        Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked", "--offline"])
            .args(["--filter-platform", host])
            .current_dir(root()),
    );
    let metadata: Value = serde_json::from_str(&metadata).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    // Ours are among them, and what they need.
    assert!(packages.len() > 100, "{} packages", packages.len());
    for package in packages {
        let (name, licence) = (&package["name"], package["license"].as_str().unwrap_or_default());
        let expression = Expression::parse_mode(licence, ParseMode::LAX)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let fits = expression.evaluate(|needed| match &needed.license {
            LicenseItem::Spdx { id, .. } => allowed.contains(&id.name),
            LicenseItem::Other(_) => false,
        });
        assert!(fits, "{name} has the licence {licence}; deny.toml allows {allowed:?}");
    }
}
