//! Where the energy and area of memories on the chip come from.

use super::quoted;
use anyhow::anyhow;
use clap::Args;
use pellucid_machine::Model;
use pellucid_testbench::area::liberty::Library;
use pellucid_testbench::area::standard::{DEFAULT_LIBRARY, logic};
use pellucid_testbench::costs::{Logic, Table, TableError, Technology};
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct TechnologyArgs {
    /// The technology of memories on the chip, in nm: 45, 32 or 22, or one of --sram
    #[arg(long, value_name = "NM", default_value_t = Technology::NODE, allow_hyphen_values = true)]
    pub(super) node: u32,
    /// A table of memories on the chip in place of the one of CACTI 7: a CSV file, see the book
    #[arg(long, value_name = "FILE.csv")]
    pub(super) sram: Option<PathBuf>,
}

impl TechnologyArgs {
    /// The technology that the command line names.
    pub(super) fn open(&self) -> anyhow::Result<Technology> {
        self.read().map_err(|error| match error {
            error @ TableError::Node { .. } => anyhow!("--node {}: {error}", self.node),
            error => error.into(),
        })
    }

    /// The technology.
    pub(super) fn read(&self) -> Result<Technology, TableError> {
        let table = match &self.sram {
            Some(path) => Table::open(path)?,
            None => Table::shipped(),
        };
        Technology::new(&table, self.node)
    }

    /// What is given of it, as a shell takes it.
    pub(super) fn given(&self) -> Vec<String> {
        let node = (self.node != Technology::NODE).then(|| format!("--node {}", self.node));
        let sram = self.sram.as_ref();
        let sram = sram.map(|path| format!("--sram {}", quoted(&path.display().to_string())));
        node.into_iter().chain(sram).collect()
    }
}

/// In which cells logic is mapped, if it is.
#[derive(Args)]
pub(super) struct LibertyArgs {
    /// Map logic to the standard cells of a library, a Liberty file that may be packed with gzip, and time them: by Yosys and OpenSTA, which
    /// takes seconds to minutes; what was found is kept. Several files are one library. Without FILE those of Debian's package
    /// qflow-tech-osu018
    #[arg(long, value_name = "FILE.lib", num_args = 0.., default_missing_value = DEFAULT_LIBRARY)]
    liberty: Vec<PathBuf>,
}

impl LibertyArgs {
    /// The library.
    pub(super) fn open(&self) -> anyhow::Result<Option<Library>> {
        if self.liberty.is_empty() {
            return Ok(None);
        }
        Ok(Some(Library::open(&self.liberty)?))
    }

    /// What is given of it, as a shell takes it.
    pub(super) fn given(&self) -> Option<String> {
        let paths = self.liberty.iter().map(|path| quoted(&path.display().to_string()));
        let paths = paths.collect::<Vec<_>>().join(" ");
        (!paths.is_empty()).then(|| format!("--liberty {paths}"))
    }
}

/// What the logic of a machine takes in the cells of a library, if there is one.
pub(super) fn logic_in(
    library: Option<&Library>,
    arch: &'static str,
    machine: &dyn Model,
    technology: &Technology,
    quiet: bool,
) -> anyhow::Result<Option<Logic>> {
    let logic = library.map(|library| logic(arch, machine, library, technology, quiet));
    Ok(logic.transpose()?)
}
