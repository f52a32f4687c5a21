//! The table's file.
//!
//! CSV with the header [`HEADER`]; lines that begin with `#` are passed over. For each node and each kind of ports there is a row
//! for every size with every width.

use crate::Price;
use crate::grid::Grid;
use pellucid_sim::Ports;
use std::path::Path;

/// The columns.
pub const HEADER: &str =
    "node_nm,ports,word_bits,bytes,access_ns,cycle_ns,read_nj,write_nj,leakage_mw,area_mm2";

/// What is wrong with a table's file.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file could not be read.
    #[error("{file}: {error}")]
    Read {
        /// Its path.
        file: String,
        /// Why.
        error: std::io::Error,
    },
    /// A line that is none of a table.
    #[error("{file}: line {line}: {problem}")]
    Line {
        /// The file's path.
        file: String,
        /// The line's number, from 1.
        line: usize,
        /// What was found, and what was expected.
        problem: String,
    },
    /// A point that is not there.
    #[error(
        "{file}: node {node}, {ports}: no row with {bits} word_bits and {bytes} bytes: expected every size with every width"
    )]
    Hole {
        /// The file's path.
        file: String,
        /// The node, nm.
        node: u32,
        /// The kind of ports.
        ports: &'static str,
        /// The width.
        bits: u32,
        /// The size.
        bytes: u64,
    },
    /// A node without a kind of ports, or no node at all.
    #[error("{file}: {problem}")]
    Missing {
        /// The file's path.
        file: String,
        /// What, and what was expected.
        problem: String,
    },
    /// A node that the table does not have.
    #[error("unknown node `{nm}`; known are {known} (nm, of {file})")]
    Node {
        /// What was asked for, nm.
        nm: u32,
        /// Those of the table.
        known: String,
        /// The file's path.
        file: String,
    },
}

/// Memories of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its name, nm.
    pub nm: u32,
    one: Grid,
    two: Grid,
}

impl Node {
    pub(crate) fn grid(&self, ports: Ports) -> &Grid {
        match ports {
            Ports::One => &self.one,
            Ports::OneReadOneWrite => &self.two,
        }
    }
}

/// A table of memories.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What it is called: the tool of the one that is shipped, else the file's path.
    pub name: String,
    nodes: Vec<Node>,
}

/// What the shipped table is called.
const SHIPPED: &str = "CACTI 7";

/// The kinds of ports, as rows name them.
const PORTS: [(&str, Ports); 2] = [("1rw", Ports::One), ("1r1w", Ports::OneReadOneWrite)];

/// A row of the file.
struct Row {
    node: u32,
    ports: Ports,
    bits: u32,
    bytes: u64,
    price: Price,
}

impl Table {
    /// The table that is shipped.
    ///
    /// # Panics
    /// Never: a test reads it.
    pub fn shipped() -> Table {
        Table::parse(SHIPPED, include_str!("cacti7.csv")).expect("the table that is shipped")
    }

    /// A table from a user's file.
    ///
    /// # Errors
    /// The file cannot be read, or [`Table::parse`] refuses it.
    pub fn open(path: &Path) -> Result<Table, TableError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Table::parse(&file, &text),
            Err(error) => Err(TableError::Read { file, error }),
        }
    }

    /// A table from the text of a file; `file` is what it is called.
    ///
    /// # Errors
    /// A line is none of a table, a point is there twice or missing, or a kind of ports is.
    pub fn parse(file: &str, text: &str) -> Result<Table, TableError> {
        let wrong =
            |line: usize, problem| TableError::Line { file: file.to_string(), line, problem };
        let missing = |problem| TableError::Missing { file: file.to_string(), problem };
        let lines = text.lines().zip(1..).map(|(line, number)| (number, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        match lines.next() {
            Some((_, HEADER)) => {}
            Some((line, found)) => {
                return Err(wrong(line, format!("`{found}`: expected the header `{HEADER}`")));
            }
            None => return Err(missing(format!("no line: expected the header `{HEADER}`"))),
        }
        let mut rows: Vec<Row> = vec![];
        for (number, line) in lines {
            let row = row(line).map_err(|problem| wrong(number, problem))?;
            let same = |other: &Row| {
                (other.node, other.ports, other.bits, other.bytes)
                    == (row.node, row.ports, row.bits, row.bytes)
            };
            if rows.iter().any(same) {
                let problem =
                    "a row of that node, ports, word_bits and bytes stands above: expected one";
                return Err(wrong(number, problem.to_string()));
            }
            rows.push(row);
        }
        let names = distinct(rows.iter().map(|row| row.node));
        if names.is_empty() {
            return Err(missing("no row: expected a row for each memory".to_string()));
        }
        let nodes = names.into_iter().map(|node| {
            let [one, two] = PORTS.map(|(name, ports)| {
                let of_kind: Vec<&Row> =
                    rows.iter().filter(|row| (row.node, row.ports) == (node, ports)).collect();
                grid(file, node, name, &of_kind)
            });
            Ok(Node { nm: node, one: one?, two: two? })
        });
        Ok(Table { name: file.to_string(), nodes: nodes.collect::<Result<_, _>>()? })
    }

    /// The node of that name, nm.
    ///
    /// # Errors
    /// The table has none of that name.
    pub fn node(&self, nm: u32) -> Result<&Node, TableError> {
        self.nodes.iter().find(|node| node.nm == nm).ok_or_else(|| {
            let known: Vec<String> =
                self.nodes.iter().map(|node| format!("`{}`", node.nm)).collect();
            TableError::Node { nm, known: known.join(", "), file: self.name.clone() }
        })
    }
}

/// The values that there are, rising.
fn distinct<T: Ord>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

fn grid(file: &str, node: u32, ports: &'static str, rows: &[&Row]) -> Result<Grid, TableError> {
    let file = file.to_string();
    if rows.is_empty() {
        let problem = format!("node {node} has no row of ports {ports}: expected 1rw and 1r1w");
        return Err(TableError::Missing { file, problem });
    }
    let widths = distinct(rows.iter().map(|row| row.bits));
    let sizes = distinct(rows.iter().map(|row| row.bytes));
    let price = |bits, bytes| {
        let row = rows.iter().find(|row| (row.bits, row.bytes) == (bits, bytes));
        let hole = || TableError::Hole { file: file.clone(), node, ports, bits, bytes };
        row.map(|row| row.price).ok_or_else(hole)
    };
    let of_width = |bits: &u32| sizes.iter().map(|bytes| price(*bits, *bytes)).collect();
    let prices = widths.iter().map(of_width).collect::<Result<_, _>>()?;
    Ok(Grid { widths, sizes, prices })
}

/// A row, or what is wrong with it.
fn row(line: &str) -> Result<Row, String> {
    let columns: Vec<&str> = HEADER.split(',').collect();
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    if fields.len() != columns.len() {
        return Err(format!("{} fields: expected {}, {HEADER}", fields.len(), columns.len()));
    }
    let wrong = |k: usize, expected: &str| {
        format!("column {} is `{}`: expected {expected}", columns[k], fields[k])
    };
    let whole = |k: usize, most: u64| {
        let number = fields[k].parse::<u64>().ok().filter(|number| (1..=most).contains(number));
        number.ok_or_else(|| wrong(k, &format!("a whole number from 1 to {most}")))
    };
    let positive = |k: usize| {
        let number = fields[k].parse::<f64>().ok();
        let number = number.filter(|number| (1e-12..=1e12).contains(number));
        number.ok_or_else(|| wrong(k, "a number above 0"))
    };
    let ports = PORTS.iter().find(|(name, _)| *name == fields[1]);
    Ok(Row {
        node: whole(0, 1_000_000)? as u32,
        ports: ports.ok_or_else(|| wrong(1, "1rw or 1r1w"))?.1,
        bits: whole(2, 65_536)? as u32,
        bytes: whole(3, 1 << 40)?,
        price: Price {
            access_ns: positive(4)?,
            cycle_ns: positive(5)?,
            read_nj: positive(6)?,
            write_nj: positive(7)?,
            leakage_mw: positive(8)?,
            area_mm2: positive(9)?,
        },
    })
}
