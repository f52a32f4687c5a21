//! Where the energy and area of memories on the chip come from.

use anyhow::anyhow;
use clap::Args;
use pellucid_testbench::costs::{Table, TableError, Technology};
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct TechnologyArgs {
    /// The technology of memories on the chip, in nm: 45, 32 or 22, or one of --sram
    #[arg(long, value_name = "NM", default_value_t = Technology::NODE, allow_hyphen_values = true)]
    node: u32,
    /// A table of memories on the chip in place of the one of CACTI 7: a CSV file, see the book
    #[arg(long, value_name = "FILE.csv")]
    sram: Option<PathBuf>,
}

impl TechnologyArgs {
    /// The technology.
    pub(super) fn open(&self) -> anyhow::Result<Technology> {
        let table = match &self.sram {
            Some(path) => Table::open(path)?,
            None => Table::shipped(),
        };
        Technology::new(&table, self.node).map_err(|error| match error {
            error @ TableError::Node { .. } => anyhow!("--node {}: {error}", self.node),
            error => error.into(),
        })
    }

    /// What is given of it, as a shell takes it.
    pub(super) fn given(&self) -> Vec<String> {
        let node = (self.node != Technology::NODE).then(|| format!("--node {}", self.node));
        let sram = self.sram.as_ref();
        let sram =
            sram.map(|path| format!("--sram {}", super::quoted(&path.display().to_string())));
        node.into_iter().chain(sram).collect()
    }
}
