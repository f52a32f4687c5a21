//! The ports of a machine in every cycle, as a file for the lock-step testbench.

use crate::output::{AtomicFile, OutputError};
use pellucid_machine::dut::{At, Observed, Observer, Quiet};
use pellucid_sim::netlist::Module;
use pellucid_verilog::lockstep::Vectors;
use std::io;
use std::path::{Path, PathBuf};

/// See the module's description.
pub(crate) struct PortRecorder {
    vectors: Vectors<AtomicFile>,
    path: PathBuf,
    inputs: Vec<u64>,
    outputs: Vec<u64>,
    /// What went wrong first; nothing is written after that.
    error: Option<io::Error>,
}

impl PortRecorder {
    /// Writes to the file `path`, for a netlist.
    pub(crate) fn new(path: &Path, netlist: &Module) -> Result<PortRecorder, OutputError> {
        let vectors = Vectors::new(netlist, AtomicFile::create(path)?);
        let (inputs, outputs) = (vec![], vec![]);
        Ok(PortRecorder { vectors, path: path.to_owned(), inputs, outputs, error: None })
    }

    fn keep(&mut self, written: io::Result<()>) {
        if let Err(error) = written {
            self.error.get_or_insert(error);
        }
    }

    /// Ends the file.
    pub(crate) fn finish(self) -> Result<(), OutputError> {
        let PortRecorder { vectors, path, error, .. } = self;
        let file = match error {
            Some(error) => Err(error),
            None => vectors.finish(),
        };
        file.map_err(|error| OutputError::write(&path, &error))?.finish()
    }
}

impl Observer for PortRecorder {
    fn cycle(&mut self, _: At, seen: &dyn Observed) -> Quiet {
        if self.error.is_none() {
            self.inputs.clear();
            self.outputs.clear();
            seen.ports(&mut self.inputs, &mut self.outputs);
            let written = self.vectors.cycle(&self.inputs, &self.outputs);
            self.keep(written);
        }
        Quiet::default()
    }

    fn reset(&mut self) {
        let written = self.vectors.reset();
        self.keep(written);
    }
}
