//! How large a machine must be so that it loses nothing of a frame.

/// What must be there. Units are what the architecture hands out or numbers: sections, pages, fragments, layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// Units that the frame needs, on chip and outside together.
    pub units: u64,
    /// The parameter that says what is held on chip.
    pub on_chip: String,
    /// What a unit counts in that parameter.
    pub of_unit: u64,
    /// The least that it may be for this frame.
    pub least: u64,
    /// How the rest is said.
    pub rest: Rest,
}

/// How what is not on chip is said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Nothing is outside. What is on chip may be less than the frame needs: it is sent again then.
    Nothing,
    /// By a parameter for the units beyond those on chip.
    Beyond(String),
    /// By parameters for all units, wherever they lie. With fewer than the first says fragments are dropped, with fewer than the
    /// others the frame is sent again.
    All(Vec<String>),
}

impl Rest {
    /// By parameters of these names for all units.
    pub fn all(names: &[&str]) -> Rest {
        Rest::All(names.iter().map(ToString::to_string).collect())
    }
}

impl Room {
    /// The same of the part `part` of an architecture.
    #[must_use]
    pub fn of_part(self, part: &str) -> Room {
        let of_part = |name: String| format!("{part}.{name}");
        let rest = match self.rest {
            Rest::Nothing => Rest::Nothing,
            Rest::Beyond(name) => Rest::Beyond(of_part(name)),
            Rest::All(names) => Rest::All(names.into_iter().map(of_part).collect()),
        };
        Room { on_chip: of_part(self.on_chip), rest, ..self }
    }

    /// All parameters that say how large it is.
    pub fn names(&self) -> Vec<&str> {
        let rest = match &self.rest {
            Rest::Nothing => &[],
            Rest::Beyond(name) => std::slice::from_ref(name),
            Rest::All(names) => &names[..],
        };
        [&self.on_chip].into_iter().chain(rest).map(String::as_str).collect()
    }

    /// The parameter that must be larger where fragments would be dropped, if one says what lies outside, and the least that
    /// it must be beside so much on chip.
    pub fn outside(&self, on_chip: u64) -> Option<(&str, u64)> {
        match &self.rest {
            Rest::Nothing => None,
            Rest::Beyond(name) => Some((name, self.units.saturating_sub(on_chip / self.of_unit))),
            Rest::All(names) => names.first().map(|name| (&**name, self.units)),
        }
    }
}
