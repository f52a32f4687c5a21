//! Names that users write: choices of a few, and the known name that is most like an unknown one.

use pellucid_machine::architecture::quoted;
use pellucid_machine::params::{did_you_mean, nearest};

/// A name that is none of the known ones.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown {what} `{name}`{}; known are {known}", did_you_mean(.nearest))]
pub struct NameError {
    /// What was to be named.
    pub what: &'static str,
    /// What was given.
    pub name: String,
    /// The known name most like it.
    pub nearest: Option<&'static str>,
    /// All known names.
    pub known: String,
}

impl NameError {
    /// Of `name`, which is not among `known`.
    pub(crate) fn new(what: &'static str, name: &str, known: &[&'static str]) -> NameError {
        NameError {
            what,
            name: name.to_string(),
            nearest: nearest(name, known.iter().copied()),
            known: quoted(known),
        }
    }
}

/// Declares an enum of which users write the names.
macro_rules! names {
    ($(#[$meta:meta])* $vis:vis enum $name:ident: $what:literal {
        $($(#[$vmeta:meta])* $variant:ident = $text:literal,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $name { $($(#[$vmeta])* $variant,)* }
        impl $name {
            /// All of them.
            pub const ALL: &[$name] = &[$($name::$variant),*];
            /// Their names.
            pub const NAMES: &[&'static str] = &[$($text),*];
        }
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str(match self { $($name::$variant => $text,)* })
            }
        }
        impl std::str::FromStr for $name {
            type Err = $crate::names::NameError;
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                match text {
                    $($text => Ok($name::$variant),)*
                    _ => Err($crate::names::NameError::new($what, text, Self::NAMES)),
                }
            }
        }
    };
}
pub(crate) use names;

#[cfg(test)]
mod tests {
    use crate::{Mapping, Page};

    #[test]
    fn messages() {
        let message = "row-bank-colum".parse::<Mapping>().unwrap_err().to_string();
        assert_eq!(
            message,
            "unknown mapping `row-bank-colum` (did you mean `row-bank-column`?); known are `row-bank-column`, \
             `row-column-bank`, `bank-row-column`, `row-bank-column-group`"
        );
        let message = "zzz".parse::<Page>().unwrap_err().to_string();
        assert_eq!(message, "unknown page policy `zzz`; known are `open`, `closed`");
        for &mapping in Mapping::ALL {
            assert_eq!(mapping.to_string().parse(), Ok(mapping));
        }
    }
}
