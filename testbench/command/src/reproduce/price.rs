//! What a run costs beside cycles, as its report says.

use pellucid_testbench::trial::Trial;
use serde_json::{Value as Json, json};

/// See the module's description. Of the memories on the chip, by the table that a run takes if nothing is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Price {
    /// Reads and writes, nJ a frame.
    pub accesses_nj: f64,
    /// Leakage, nJ a frame.
    pub leakage_nj: f64,
    /// Area, mm2.
    pub area_mm2: f64,
}

impl Price {
    /// What its figures are called.
    pub const NAMES: [&str; 3] =
        ["reads and writes, nJ a frame", "leakage, nJ a frame", "memories, mm2"];

    /// What its columns are called in a table for programs.
    pub const COLUMNS: &str = "accesses_nj,leakage_nj,area_mm2";

    /// What a report says.
    pub fn read(report: &Json) -> Option<Price> {
        let energy = |name: &str| report["energy"][name].as_f64();
        Some(Price {
            accesses_nj: energy("reads")? + energy("writes")?,
            leakage_nj: energy("leakage")?,
            area_mm2: report["area"]["memories"].as_f64()?,
        })
    }

    /// What a trial says.
    pub fn of(trial: &Trial) -> Price {
        Price::read(&trial.report.json()).expect("a run has its energy and area")
    }

    /// Its figures, in the order of their names.
    pub fn figures(&self) -> [f64; 3] {
        [self.accesses_nj, self.leakage_nj, self.area_mm2]
    }

    /// A figure for people: four digits.
    pub fn shown(figure: f64) -> String {
        match figure {
            0.0 => "0".to_string(),
            figure if figure >= 1000.0 => super::number(figure.round() as u64),
            figure => {
                let digits = (3 - figure.log10().floor() as i32).max(0) as usize;
                format!("{figure:.digits$}")
            }
        }
    }

    /// Its figures in these columns.
    pub fn csv(&self) -> String {
        self.figures().map(|figure| figure.to_string()).join(",")
    }

    /// The same for programs.
    pub fn json(&self) -> Json {
        let Price { accesses_nj, leakage_nj, area_mm2 } = self;
        json!({ "accesses_nj": accesses_nj, "leakage_nj": leakage_nj, "area_mm2": area_mm2 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits() {
        let shown = [0.0, 0.012345, 12.3456, 999.96, 1234.5, 1_234_567.0].map(Price::shown);
        assert_eq!(shown, ["0", "0.01235", "12.35", "1000.0", "1,235", "1,234,567"]);
    }
}
