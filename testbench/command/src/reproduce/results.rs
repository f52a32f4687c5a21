//! What a reproduction leaves: a page, the same as JSON and CSV, and a word on it.

use crate::say;
use pellucid_testbench::output::{OutputError, put};
use serde_json::Value as Json;
use std::io;
use std::path::Path;

/// What is left of a reproduction.
pub struct Results {
    /// What its files are called.
    pub name: &'static str,
    /// The page, or why there is none.
    pub page: io::Result<String>,
    /// The same for programs.
    pub json: Json,
    /// Every run as a table.
    pub csv: String,
    /// What is printed of it.
    pub text: String,
    /// Every image is right, and every count its closed form.
    pub exact: bool,
}

impl Results {
    /// Writes the files below `out`, and prints the JSON or the text.
    ///
    /// # Errors
    /// The page could not be made, or a file not be written.
    pub fn leave(self, out: &Path, as_json: bool) -> anyhow::Result<()> {
        let path = |ending: &str| out.join(format!("{}.{ending}", self.name));
        let page = path("html");
        put(&page, &self.page.map_err(|error| OutputError::write(&page, &error))?)?;
        put(&path("json"), &format!("{:#}\n", self.json))?;
        put(&path("csv"), &self.csv)?;
        if as_json {
            return Ok(say(&format!("{:#}\n", self.json))?);
        }
        let mut text = self.text;
        text += if self.exact {
            "\nEvery image is right, and every count its closed form.\n\n"
        } else {
            "\nNot every count is its closed form: see what is said on standard error.\n\n"
        };
        for (path, what) in [
            (page, "the paper's figures with plots, for a browser"),
            (path("json"), "the same for programs, with the command of every run"),
            (path("csv"), "every run and each of its frames as a table"),
            (out.join("runs"), "what every run counted; what is there is not run again"),
        ] {
            text += &format!("  {:32} {what}\n", path.display());
        }
        Ok(say(&text)?)
    }
}
