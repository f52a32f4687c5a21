//! Parameters of an architecture: declared once, with default, range, unit and sentence, for the
//! command line, configuration files, listings and error messages alike.

use std::fmt;

/// What a listing tells of one parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Param {
    /// Its name; one of a part of the architecture has the part's name before a dot.
    pub name: String,
    /// The default, as text.
    pub default: String,
    /// What it counts; empty for a choice.
    pub unit: &'static str,
    /// What it may be, as text.
    pub range: String,
    /// One sentence.
    pub about: &'static str,
}

/// A parameter's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// A number.
    Number(u32),
    /// One of a few names.
    Choice(&'static str),
    /// Any text.
    Text(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Value::Number(n) => n.fmt(f),
            Value::Choice(name) => name.fmt(f),
            Value::Text(text) => text.fmt(f),
        }
    }
}

/// A parameter that was not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParamError {
    /// No parameter of that name.
    #[error("unknown parameter `{name}`{}; known are {known}", did_you_mean(nearest))]
    Unknown {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<String>,
        /// All known names.
        known: String,
    },
    /// A value outside the range.
    #[error("parameter `{name}` is {found}: expected {expected}")]
    Value {
        /// The parameter.
        name: String,
        /// What was given.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// Values that do not go together.
    #[error("{0}")]
    Together(String),
}

impl ParamError {
    /// The same of a parameter, or of several, of the part `part`, whose parameters are `P`.
    #[must_use]
    pub fn of_part<P: Parameters>(self, part: &str) -> ParamError {
        match self {
            ParamError::Value { name, found, expected } => {
                ParamError::Value { name: format!("{part}.{name}"), found, expected }
            }
            ParamError::Together(mut text) => {
                for Param { name, .. } in P::list() {
                    for end in ["`", "="] {
                        text =
                            text.replace(&format!("`{name}{end}"), &format!("`{part}.{name}{end}"));
                    }
                }
                ParamError::Together(text)
            }
            unknown @ ParamError::Unknown { .. } => unknown,
        }
    }
}

/// A preset: a name for a set of parameters.
pub struct Preset<P> {
    /// Its name.
    pub name: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Makes the parameters.
    pub params: fn() -> P,
}

/// Fragments that an architecture may hold: what a simulation can hold in memory.
pub const MAX_FRAGMENTS: u64 = 1 << 28;

/// Checks how many fragments the parameters that `what` names hold together.
///
/// # Errors
/// They are more than [`MAX_FRAGMENTS`].
pub fn too_many_fragments(what: &str, fragments: u64) -> Result<(), ParamError> {
    if fragments <= MAX_FRAGMENTS {
        return Ok(());
    }
    Err(ParamError::Together(format!(
        "parameters {what} hold {fragments} fragments: expected at most {MAX_FRAGMENTS}"
    )))
}

/// Holds a parameter to powers of two.
///
/// # Errors
/// It is none.
pub fn power_of_two(name: &str, value: u32) -> Result<(), ParamError> {
    if value.is_power_of_two() {
        return Ok(());
    }
    Err(ParamError::Value {
        name: name.to_string(),
        found: value.to_string(),
        expected: "a power of two".to_string(),
    })
}

/// ` (did you mean ...?)`, or nothing where no name is near.
pub fn did_you_mean(nearest: &Option<impl AsRef<str>>) -> String {
    match nearest {
        Some(name) => format!(" (did you mean `{}`?)", name.as_ref()),
        None => String::new(),
    }
}

/// The name in `known` that is most like `name`, if one is alike at all.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|k| (strsim::jaro_winkler(name, k), k))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, k)| k)
}

/// A set of parameters.
pub trait Parameters: Copy {
    /// Every parameter.
    fn list() -> Vec<Param>;
    /// Sets one from text.
    ///
    /// # Errors
    /// An unknown name or a value out of range; nothing is changed then.
    fn set(&mut self, name: &str, value: &str) -> Result<(), ParamError>;
    /// Every name with its value, in the order of [`Parameters::list`].
    fn values(&self) -> Vec<(String, Value)>;
}

/// A type that a parameter can have: a number in a range, or one of a few names.
pub trait ParamType: Copy {
    /// What limits it: a range for numbers, nothing for names.
    type Limits;
    /// From text.
    fn parse(text: &str, limits: &Self::Limits) -> Option<Self>;
    /// What it may be, as text.
    fn expected(limits: &Self::Limits) -> String;
    /// Itself.
    fn value(self) -> Value;
}

impl ParamType for u32 {
    type Limits = std::ops::RangeInclusive<u32>;
    fn parse(text: &str, limits: &Self::Limits) -> Option<u32> {
        text.parse().ok().filter(|n| limits.contains(n))
    }
    fn expected(limits: &Self::Limits) -> String {
        format!("a whole number from {} to {}", limits.start(), limits.end())
    }
    fn value(self) -> Value {
        Value::Number(self)
    }
}

/// What a choice may be, as text.
pub fn one_of(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &names[..] {
        [one] => format!("{one}, the only choice so far"),
        [start @ .., last] => format!("{} or {last}", start.join(", ")),
        [] => String::new(),
    }
}

/// Declares an enum that a parameter can have, with the names that users write.
#[macro_export]
macro_rules! choice {
    ($(#[$meta:meta])* $vis:vis enum $name:ident { $($(#[$vmeta:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $name { $($(#[$vmeta])* $variant,)* }
        impl $name {
            /// All of them.
            #[allow(dead_code)]
            $vis const ALL: &[$name] = &[$($name::$variant),*];
        }
        impl $crate::params::ParamType for $name {
            type Limits = ();
            fn parse(text: &str, _: &()) -> Option<Self> {
                match text { $($text => Some($name::$variant),)* _ => None }
            }
            fn expected(_: &()) -> String {
                $crate::params::one_of(&[$($text),*])
            }
            fn value(self) -> $crate::params::Value {
                $crate::params::Value::Choice(match self { $($name::$variant => $text,)* })
            }
        }
    };
}

/// Declares a struct of parameters: `name: type = default, "unit", limits;` with the doc comment as
/// the sentence that listings show. After those, `part name: type;` for the parameters of a part of the
/// architecture, whose names get that of the part and a dot.
#[macro_export]
macro_rules! parameters {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[doc = $about:literal])+ $field:ident: $ty:ty = $default:expr, $unit:literal, $limits:expr;)*
        $(part $part:ident: $params:ty;)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis struct $name {
            $($(#[doc = $about])+ pub $field: $ty,)*
            $(#[doc = concat!("Those of `", stringify!($part), "`.")] pub $part: $params,)*
        }
        impl Default for $name {
            fn default() -> Self {
                $name { $($field: $default,)* $($part: <$params as Default>::default(),)* }
            }
        }
        impl $crate::params::Parameters for $name {
            fn list() -> Vec<$crate::params::Param> {
                #[allow(unused_mut, reason = "not every architecture has parts")]
                let mut list = vec![$($crate::params::Param {
                    name: stringify!($field).to_string(),
                    default: $crate::params::ParamType::value($default as $ty).to_string(),
                    unit: $unit,
                    range: <$ty as $crate::params::ParamType>::expected(&$limits),
                    about: concat!($($about),+).trim_ascii(),
                }),*];
                $(list.extend(<$params as $crate::params::Parameters>::list().into_iter().map(|p| {
                    $crate::params::Param { name: format!("{}.{}", stringify!($part), p.name), ..p }
                }));)*
                list
            }
            fn set(&mut self, name: &str, value: &str) -> Result<(), $crate::params::ParamError> {
                match name {
                    $(stringify!($field) => {
                        self.$field = <$ty as $crate::params::ParamType>::parse(value, &$limits)
                            .ok_or_else(|| $crate::params::ParamError::Value {
                                name: stringify!($field).to_string(),
                                found: format!("`{value}`"),
                                expected: <$ty as $crate::params::ParamType>::expected(&$limits),
                            })?;
                        return Ok(());
                    })*
                    _ => {
                        $(if let Some(name) = name.strip_prefix(concat!(stringify!($part), ".")) {
                            let set = $crate::params::Parameters::set(&mut self.$part, name, value);
                            let set = set.map_err(|e| e.of_part::<$params>(stringify!($part)));
                            if !matches!(set, Err($crate::params::ParamError::Unknown { .. })) {
                                return set;
                            }
                        })*
                    }
                }
                let known: Vec<String> =
                    <Self as $crate::params::Parameters>::list().into_iter().map(|p| p.name).collect();
                Err($crate::params::ParamError::Unknown {
                    name: name.to_string(),
                    nearest: $crate::params::nearest(name, known.iter().map(String::as_str))
                        .map(str::to_string),
                    known: known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", "),
                })
            }
            fn values(&self) -> Vec<(String, $crate::params::Value)> {
                #[allow(unused_mut, reason = "not every architecture has parts")]
                let mut values = vec![
                    $((stringify!($field).to_string(), $crate::params::ParamType::value(self.$field))),*
                ];
                $(values.extend(
                    $crate::params::Parameters::values(&self.$part)
                        .into_iter()
                        .map(|(name, value)| (format!("{}.{name}", stringify!($part)), value)),
                );)*
                values
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    choice! {
        /// Where.
        pub enum Side { /// Left.
            Left = "left", /// Right.
            Right = "right", }
    }
    parameters! {
        /// Some.
        pub struct Some3 {
            /// How many.
            sections: u32 = 5, "sections", 1..=9;
            /// Which side.
            side: Side = Side::Left, "", ();
        }
    }

    parameters! {
        /// Some, and those of a part.
        pub struct Whole {
            /// How deep.
            depth: u32 = 2, "", 1..=3;
            part inner: Some3;
        }
    }

    #[test]
    fn a_part_has_its_own() {
        let mut whole = Whole::default();
        whole.set("inner.sections", "9").unwrap();
        whole.set("depth", "3").unwrap();
        assert_eq!(whole, Whole { depth: 3, inner: Some3 { sections: 9, ..Some3::default() } });
        let names: Vec<String> = Whole::list().into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["depth", "inner.sections", "inner.side"]);
        let values: Vec<String> =
            whole.values().iter().map(|(name, value)| format!("{name}={value}")).collect();
        assert_eq!(values, ["depth=3", "inner.sections=9", "inner.side=left"]);
        let mut message = |name, value| whole.set(name, value).unwrap_err().to_string();
        assert_eq!(
            message("inner.sections", "0"),
            "parameter `inner.sections` is `0`: expected a whole number from 1 to 9"
        );
        for (unknown, nearest) in
            [("inner.section", "inner.sections"), ("sections", "inner.sections")]
        {
            assert_eq!(
                message(unknown, "1"),
                format!(
                    "unknown parameter `{unknown}` (did you mean `{nearest}`?); known are `depth`, \
                     `inner.sections`, `inner.side`"
                )
            );
        }
        let together = ParamError::Together("`sections` and `side=left`, not `depths`".into());
        assert_eq!(
            together.of_part::<Some3>("inner").to_string(),
            "`inner.sections` and `inner.side=left`, not `depths`"
        );
    }

    #[test]
    fn set_and_list() {
        let mut p = Some3::default();
        p.set("sections", "9").unwrap();
        p.set("side", "right").unwrap();
        assert_eq!(p, Some3 { sections: 9, side: Side::Right });
        let list = Some3::list();
        assert_eq!((list[0].default.as_str(), list[0].about), ("5", "How many."));
        assert_eq!(list[1].range, "`left` or `right`");
    }

    #[test]
    fn messages() {
        let mut p = Some3::default();
        let message = |r: Result<(), ParamError>| r.unwrap_err().to_string();
        assert_eq!(
            message(p.set("section", "9")),
            "unknown parameter `section` (did you mean `sections`?); known are `sections`, `side`"
        );
        assert_eq!(
            message(p.set("qqq", "9")),
            "unknown parameter `qqq`; known are `sections`, `side`"
        );
        for bad in ["0", "10", "-1", "x", "", "4294967296"] {
            assert_eq!(
                message(p.set("sections", bad)),
                format!("parameter `sections` is `{bad}`: expected a whole number from 1 to 9")
            );
        }
        assert_eq!(
            message(p.set("side", "up")),
            "parameter `side` is `up`: expected `left` or `right`"
        );
        assert_eq!(p, Some3::default());
    }
}
