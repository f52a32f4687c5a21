//! Statistics: counters declared with their unit and their sentence.
//!
//! [`counters!`](crate::counters) makes a struct of `u64` counters; the doc comment of each is the
//! sentence that every report shows.

/// One figure of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name, unique in its group.
    pub name: &'static str,
    /// What is counted.
    pub unit: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// The count.
    pub value: u64,
}

/// A group of figures.
pub trait Figures {
    /// All of them, in the order of their declaration.
    fn figures(&self) -> Vec<Figure>;
}

/// Declares a struct of counters.
/// ```
/// use pellucid_sim::{Figures, counters};
/// counters! {
///     /// What the store unit did.
///     pub struct Store {
///         /// Fragments that were stored.
///         stored: "fragments",
///     }
/// }
/// let figure = &Store { stored: 3 }.figures()[0];
/// assert_eq!((figure.name, figure.unit, figure.value), ("stored", "fragments", 3));
/// assert_eq!(figure.about, "Fragments that were stored.");
/// ```
#[macro_export]
macro_rules! counters {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[doc = $about:literal])+ $field:ident: $unit:literal,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        $vis struct $name { $($(#[doc = $about])+ pub $field: u64,)* }
        impl $crate::Figures for $name {
            fn figures(&self) -> Vec<$crate::Figure> {
                vec![$($crate::Figure {
                    name: stringify!($field),
                    unit: $unit,
                    about: concat!($($about),+).trim_ascii(),
                    value: self.$field,
                }),*]
            }
        }
    };
}
