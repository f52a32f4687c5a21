//! What a waveform holds: every signal of a machine with its place, and what is derived from signals.
//!
//! Two things are derived. A stream gets `stall`: something is offered and not taken. A [`Label`](pellucid_sim::Label) below a scope with `valid` is moved up to it and
//! is shown while `valid` is high, so that a stage which holds nothing shows nothing.

use pellucid_sim::{Declare, Kind};
use wildmatch::WildMatch;

/// Something to be shown.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    /// The scopes that it stands in, from the outermost on.
    pub(crate) scopes: Vec<String>,
    pub(crate) name: String,
    pub(crate) form: Form,
    /// It is part of the waveform.
    pub(crate) shown: bool,
}

/// What an entry is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// Value `at`, of so many bits.
    Bits { at: usize, width: u32, kind: Kind },
    /// Label `at`.
    Label { at: usize },
}

impl Entry {
    /// Its name with those of its scopes.
    pub(crate) fn path(&self) -> String {
        let mut path = self.scopes.join(".");
        path.push('.');
        path + &self.name
    }
}

/// A step through the scopes of a layout.
pub(crate) enum Walk<'a> {
    /// A scope is entered.
    Enter(&'a str),
    /// The innermost one is left.
    Leave,
    /// Something is shown there.
    Entry(&'a Entry),
}

/// A stream whose offer may not be taken: where its wires are among the values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stall {
    pub(crate) valid: usize,
    pub(crate) ready: usize,
}

/// A stream of a machine: a scope of that name among its wires, with `valid` and `ready`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamOf {
    /// Its name.
    pub name: String,
    /// The block that receives it.
    pub to: String,
}

/// See the module's description.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    pub(crate) entries: Vec<Entry>,
    pub(crate) streams: Vec<StreamOf>,
    /// How many values are sampled. Those of the streams' stalls follow them.
    pub(crate) sampled: usize,
    pub(crate) stalls: Vec<Stall>,
    /// For each label, the value that must be 1 for it to be shown.
    pub(crate) gates: Vec<Option<usize>>,
}

/// A pattern of [`Layout::select`] that no signal fits.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{pattern}` fits no signal; there is `{example}`, for instance")]
pub struct NoSignal {
    pattern: String,
    example: String,
}

/// Gathers declarations.
#[derive(Default)]
struct Gather {
    scopes: Vec<String>,
    layout: Layout,
}

/// A name that every format takes: letters, digits, `_`, and brackets for elements of arrays.
fn legal(name: &str) -> String {
    let name = name.strip_prefix("r#").unwrap_or(name);
    let keeps = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '[' | ']');
    name.chars().map(|c| if keeps(c) { c } else { '_' }).collect()
}

impl Gather {
    /// The value of a signal that was declared.
    fn value(&self, scopes: &[String], name: &str) -> Option<usize> {
        let entries = &self.layout.entries;
        entries.iter().rev().find_map(|entry| match entry.form {
            Form::Bits { at, .. } if entry.name == name && entry.scopes == scopes => Some(at),
            _ => None,
        })
    }
    fn add(&mut self, scopes: Vec<String>, name: String, form: Form) {
        self.layout.entries.push(Entry { scopes, name, form, shown: true });
    }
}

impl Declare for Gather {
    fn open(&mut self, name: &str) {
        self.scopes.push(legal(name));
    }
    fn close(&mut self) {
        self.scopes.pop();
    }
    fn signal(&mut self, name: &str, width: u32, kind: Kind) {
        let at = self.layout.sampled;
        self.layout.sampled += 1;
        self.add(self.scopes.clone(), legal(name), Form::Bits { at, width, kind });
        let is_stream = |name: &String| self.layout.streams.iter().any(|s| s.name == *name);
        if name == "ready"
            && self.scopes.last().is_some_and(is_stream)
            && let Some(valid) = self.value(&self.scopes, "valid")
        {
            // Where its value is, is known once all signals are.
            let form = Form::Bits { at: usize::MAX, width: 1, kind: Kind::Flag };
            self.add(self.scopes.clone(), "stall".into(), form);
            self.layout.stalls.push(Stall { valid, ready: at });
        }
    }
    fn label(&mut self, name: &str) {
        let at = self.layout.gates.len();
        let depths = (0..=self.scopes.len()).rev();
        let mut gates =
            depths.filter_map(|len| Some((len, self.value(&self.scopes[..len], "valid")?)));
        let (scopes, gate) = match gates.next() {
            Some((len, gate)) => (self.scopes[..len].to_vec(), Some(gate)),
            None => (self.scopes.clone(), None),
        };
        self.layout.gates.push(gate);
        // It stands beside `valid`, so that what follows stays together.
        let beside = |entry: &Entry| entry.name == "valid" && entry.scopes == scopes;
        let place = self.layout.entries.iter().rposition(beside);
        let place = place.unwrap_or(self.layout.entries.len());
        let entry = Entry { scopes, name: legal(name), form: Form::Label { at }, shown: true };
        self.layout.entries.insert(place, entry);
    }
}

impl Layout {
    /// What `declare` declares: the scope of a machine, in which are those of its `registers`, its `wires` and
    /// perhaps its `memories`.
    pub fn new(streams: Vec<StreamOf>, declare: impl FnOnce(&mut dyn Declare)) -> Layout {
        let layout = Layout { streams, ..Layout::default() };
        let mut gather = Gather { layout, ..Gather::default() };
        declare(&mut gather);
        let mut layout = gather.layout;
        let stalls = layout.entries.iter_mut().filter_map(|entry| match &mut entry.form {
            Form::Bits { at, .. } if *at == usize::MAX => Some(at),
            _ => None,
        });
        for (at, place) in (layout.sampled..).zip(stalls) {
            *place = at;
        }
        layout
    }

    /// Keeps the signals that fit one of the patterns: `*` stands for any text, `?` for one character. What
    /// must fit is a signal's path below the machine, or that of a scope it is in. A pattern behind `!` leaves
    /// out what fits; if there are only such patterns, all else stays.
    ///
    /// # Errors
    /// A pattern that no signal fits.
    pub fn select(&mut self, patterns: &[String]) -> Result<(), NoSignal> {
        let mut used = vec![false; patterns.len()];
        let leaves_out = |pattern: &String| pattern.starts_with('!');
        let all = patterns.iter().all(leaves_out);
        for entry in &mut self.entries {
            let path = entry.path();
            let below = path.split_once('.').map_or(&path[..], |(_, below)| below);
            let ends = below.match_indices('.').map(|(end, _)| end).chain([below.len()]);
            let scopes: Vec<&str> = ends.map(|end| &below[..end]).collect();
            let (mut kept, mut left_out) = (all, false);
            for (pattern, used) in patterns.iter().zip(&mut used) {
                let fits = WildMatch::new(pattern.trim_start_matches('!'));
                if scopes.iter().any(|scope| fits.matches(scope)) {
                    *used = true;
                    kept |= !leaves_out(pattern);
                    left_out |= leaves_out(pattern);
                }
            }
            entry.shown = kept && !left_out;
        }
        match patterns.iter().zip(used).find(|(_, used)| !used) {
            None => Ok(()),
            Some((pattern, _)) => {
                let last = self.entries.last().map(Entry::path).unwrap_or_default();
                let example = last.split_once('.').map(|(_, below)| below.to_string());
                Err(NoSignal { pattern: pattern.clone(), example: example.unwrap_or(last) })
            }
        }
    }

    /// Goes through all that is shown, in and out of its scopes.
    pub(crate) fn walk<E>(&self, mut to: impl FnMut(Walk) -> Result<(), E>) -> Result<(), E> {
        let mut scopes: &[String] = &[];
        for entry in self.entries.iter().filter(|entry| entry.shown) {
            let common = scopes.iter().zip(&entry.scopes).take_while(|(a, b)| a == b).count();
            scopes[common..].iter().try_for_each(|_| to(Walk::Leave))?;
            entry.scopes[common..].iter().try_for_each(|name| to(Walk::Enter(name)))?;
            to(Walk::Entry(entry))?;
            scopes = &entry.scopes;
        }
        scopes.iter().try_for_each(|_| to(Walk::Leave))
    }

    /// Values of a cycle: those that are sampled and those of the stalls.
    pub(crate) fn values(&self) -> usize {
        self.sampled + self.stalls.len()
    }

    /// The events, one-bit signals in a scope `events`: name and where the value is.
    pub fn events(&self) -> impl Iterator<Item = (&str, usize)> {
        self.entries.iter().filter_map(|entry| match entry.form {
            Form::Bits { at, .. } if entry.is_event() => Some((&entry.name[..], at)),
            _ => None,
        })
    }

    /// The streams' stalls: name of the stream and where the value is.
    pub fn stalls(&self) -> impl Iterator<Item = (&str, usize)> {
        self.entries.iter().filter_map(|entry| match entry.form {
            Form::Bits { at, .. } if at >= self.sampled => {
                Some((entry.scopes.last().map_or("", |scope| &scope[..]), at))
            }
            _ => None,
        })
    }
}

impl Entry {
    pub(crate) fn is_event(&self) -> bool {
        self.scopes.last().is_some_and(|scope| scope == "events")
    }
}
