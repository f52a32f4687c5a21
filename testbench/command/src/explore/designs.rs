//! The designs of a study: machines with a value for each of their parameters.

use super::genetic::{Genes, Genetic};
use super::reading::StudyError;
use super::space::{Values, check_formulas, settle};
use super::study::{Family, MOST_DESIGNS, Method, PRESET, Search, Study};
use crate::machine::Choice;
use anyhow::bail;
use pellucid_machine::architecture::{Setting, SettingError};
use pellucid_machine::params::ParamError;
use pellucid_machine::pixel::Screen;
use pellucid_testbench::outside::board::BoardError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// A machine with a value for each of its parameters.
pub struct Design {
    /// The machine.
    pub choice: Choice,
    /// Number of its family.
    pub family: usize,
    /// What cannot be: a formula's result.
    pub refused: Option<String>,
}

/// Draws for each design that is asked for, and generations without a new one: the space may have fewer.
const DRAWS: usize = 20;

/// Every value that a study names is one that its parameter can have.
///
/// # Errors
/// One is not; the line is named.
pub fn check(families: &[Family], screen: Screen) -> anyhow::Result<()> {
    for family in families {
        check_formulas(&family.axes)?;
        let presets = family.axes[0].values.grid().unwrap_or_default();
        let names: Vec<&str> = (family.arch.presets)().into_iter().map(|preset| preset.0).collect();
        if let Some(unknown) = presets.iter().find(|preset| !names.contains(&&***preset)) {
            let place = family.axes[0].place.clone();
            // What an architecture says of a preset that it does not have.
            let Err(error) = family.arch.build(screen, Some(unknown), &[]) else { continue };
            return Err(StudyError::Line { place, problem: error.to_string() }.into());
        }
        for axis in &family.axes[1..] {
            let ends = match &axis.values {
                Values::List(list) => list.clone(),
                Values::Span { from, to, .. } => vec![from.to_string(), to.to_string()],
                // The name alone can be wrong.
                Values::Formula(_) => vec!["0".to_string()],
            };
            for value in ends {
                let setting =
                    Setting { name: axis.name.clone(), value, origin: axis.place.clone() };
                let choice = Choice::new(family.arch, &presets[0], vec![setting]);
                if let Err(error) = choice.build(screen)
                    && is_of_one(&error, matches!(axis.values, Values::Formula(_)))
                {
                    return Err(error);
                }
            }
        }
    }
    Ok(())
}

/// Whether an error is over a setting by itself, and not over several together; of a formula the value does not count.
fn is_of_one(error: &anyhow::Error, name_alone: bool) -> bool {
    let setting = error.downcast_ref::<SettingError>().and_then(|error| match error {
        SettingError::Setting { error, .. } => Some(error),
        _ => None,
    });
    let board = error.downcast_ref::<BoardError>();
    let of_board = board.and_then(|error| match error {
        BoardError::Setting { error, .. } => Some(error),
        _ => None,
    });
    match setting.or(of_board) {
        Some(ParamError::Value { .. }) => !name_alone,
        Some(_) => true,
        None => matches!(board, Some(BoardError::Part { .. })),
    }
}

/// Finds the designs of a study, one batch after the other.
pub struct Searcher<'a> {
    families: &'a [Family],
    search: Search,
    /// The number of each design that was found, by its name.
    numbers: HashMap<String, usize>,
    /// Those that were found since the last batch.
    found: Vec<Design>,
    genetic: Genetic,
    /// The last generation, each with the number of its design.
    generation: Vec<(Genes, usize)>,
}

impl Searcher<'_> {
    /// Nothing is found yet.
    pub fn new(study: &Study) -> Searcher<'_> {
        let (families, search) = (&*study.families, study.search);
        let parameters = families.iter().map(|family| family.axes.len()).max().unwrap_or(0);
        let genetic = Genetic::new(1 + parameters, search.seed);
        let (numbers, found, generation) = (HashMap::new(), vec![], vec![]);
        Searcher { families, search, numbers, found, genetic, generation }
    }

    /// The next designs to look at, each once: all of them at once, or those that are bred from the best so far. `values` has of a
    /// design each objective, as small as it can be; nothing if it is out. No designs at the end.
    ///
    /// # Errors
    /// A grid over a range without steps, or with too many designs.
    pub fn next(
        &mut self,
        values: impl Fn(usize) -> Option<Vec<f64>>,
    ) -> anyhow::Result<Vec<Design>> {
        match self.search.method {
            Method::Genetic => self.breed(values),
            _ if !self.numbers.is_empty() => {}
            Method::Grid => self.grid()?,
            Method::Random => self.random(),
            Method::Halton => self.halton(),
        }
        Ok(self.found())
    }

    /// What was found since this was last asked.
    pub fn found(&mut self) -> Vec<Design> {
        std::mem::take(&mut self.found)
    }

    /// Takes up the design of a family that has these values; its number.
    pub fn add(&mut self, family: usize, values: &[String]) -> usize {
        let Family { arch, axes, .. } = &self.families[family];
        let (preset, axes, values) = (&values[0], &axes[1..], &values[1..]);
        let (settings, refused) = match settle(axes, values) {
            Ok(settings) => (settings, None),
            Err(why) => {
                let given = axes.iter().zip(values).filter(|(_, value)| !value.is_empty());
                let given = given.map(|(axis, value)| Setting {
                    name: axis.name.clone(),
                    value: value.clone(),
                    origin: axis.place.clone(),
                });
                (given.collect(), Some(why))
            }
        };
        let choice = Choice::new(arch, preset, settings);
        let number = self.numbers.len();
        if let Some(known) = self.numbers.get(&choice.name) {
            return *known;
        }
        self.numbers.insert(choice.name.clone(), number);
        self.found.push(Design { choice, family, refused });
        number
    }

    fn grid(&mut self) -> anyhow::Result<()> {
        for (k, family) in self.families.iter().enumerate() {
            let mut grids: Vec<Vec<String>> = vec![];
            for axis in &family.axes {
                let Some(grid) = axis.values.grid() else {
                    let problem =
                        format!("the range of `{}` has no `steps`, which a grid needs", axis.name);
                    return Err(StudyError::Line { place: axis.place.clone(), problem }.into());
                };
                grids.push(grid);
            }
            let count = grids.iter().try_fold(1usize, |all, grid| all.checked_mul(grid.len()));
            if count.is_none_or(|count| count > MOST_DESIGNS) {
                bail!(
                    "{}: the grid has more than {MOST_DESIGNS} designs: expected fewer values, or another `method`",
                    family.place
                );
            }
            // The last parameter changes fastest.
            let mut at = vec![0; grids.len()];
            loop {
                let values: Vec<String> =
                    grids.iter().zip(&at).map(|(grid, at)| grid[*at].clone()).collect();
                self.add(k, &values);
                let next = (0..at.len()).rfind(|k| at[*k] + 1 < grids[*k].len());
                let Some(next) = next else { break };
                at[next] += 1;
                at[next + 1..].fill(0);
            }
        }
        Ok(())
    }

    /// The design at a place of the unit cube, whose first coordinate chooses the machine; its number.
    fn place(&mut self, mut share: impl FnMut() -> f64) -> usize {
        let families = self.families;
        let family = ((share() * families.len() as f64) as usize).min(families.len() - 1);
        let values: Vec<String> =
            families[family].axes.iter().map(|axis| axis.values.at(share())).collect();
        self.add(family, &values)
    }

    fn random(&mut self) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.search.seed);
        for _ in 0..self.search.designs.saturating_mul(DRAWS) {
            if self.numbers.len() == self.search.designs {
                break;
            }
            self.place(|| rng.random_range(0.0..1.0));
        }
    }

    fn halton(&mut self) {
        let dimensions =
            1 + self.families.iter().map(|family| family.axes.len()).max().unwrap_or(0);
        let bases: Vec<u64> = primes().take(dimensions).collect();
        for index in 1..=self.search.designs.saturating_mul(DRAWS) as u64 {
            if self.numbers.len() == self.search.designs {
                break;
            }
            let mut bases = bases.iter();
            self.place(|| radical_inverse(index, *bases.next().unwrap_or(&2)));
        }
    }

    fn breed(&mut self, values: impl Fn(usize) -> Option<Vec<f64>>) {
        for _ in 0..DRAWS {
            if !self.generation.is_empty() {
                let members = self.generation.drain(..);
                let members = members.map(|(genes, number)| (genes, values(number))).collect();
                self.genetic.tell(members);
            }
            if self.numbers.len() >= self.search.designs {
                return;
            }
            for genes in self.genetic.ask() {
                let mut shares = genes.iter().copied();
                let number = self.place(|| shares.next().unwrap_or(0.0));
                self.generation.push((genes, number));
                if self.numbers.len() == self.search.designs {
                    break;
                }
            }
            // A generation of nothing but what is known breeds on.
            if !self.found.is_empty() {
                return;
            }
        }
    }
}

/// The digits of a number behind the point, the last one first.
fn radical_inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while index > 0 {
        place /= base as f64;
        value += place * (index % base) as f64;
        index /= base;
    }
    value
}

fn primes() -> impl Iterator<Item = u64> {
    (2_u64..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| !n.is_multiple_of(d)))
}

impl Design {
    /// The parameters that the study gives it, with its preset.
    pub fn given(&self) -> Vec<(String, String)> {
        let preset = (PRESET.to_string(), self.choice.preset.clone());
        let settings = self.choice.settings.iter();
        let settings = settings.map(|setting| (setting.name.clone(), setting.value.clone()));
        [preset].into_iter().chain(settings).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::reading::File;
    use super::*;
    use std::collections::HashSet;

    fn names(search: &str) -> Vec<String> {
        let text = format!(
            "[[scene]]\nscene = \"glass\"\n[[machine]]\narch = \"tbuffer\"\nsections = [100, 200]\n\
             section_capacity = {{ from = 1, to = 4, steps = 2 }}\noutside_sections = \"= sections / 2\"\n{search}"
        );
        let study = Study::read(&File::of("s.toml", &text)).unwrap();
        let mut searcher = Searcher::new(&study);
        let mut names: Vec<String> = vec![];
        loop {
            let known = names.clone();
            let value = |name: &str| -> f64 { name.matches("=100,").count() as f64 };
            let designs = searcher.next(|number| Some(vec![value(&known[number])])).unwrap();
            if designs.is_empty() {
                return names;
            }
            names.extend(designs.into_iter().map(|design| design.choice.name));
        }
    }

    #[test]
    fn a_grid_has_every_combination_once() {
        let name = |sections: u32, capacity: u32| {
            format!(
                "tbuffer:fast,sections={sections},section_capacity={capacity},outside_sections={}",
                sections / 2
            )
        };
        assert_eq!(names(""), [name(100, 1), name(100, 4), name(200, 1), name(200, 4)]);
    }

    #[test]
    fn draws_are_different_and_the_same_each_time() {
        for method in ["random", "halton", "genetic"] {
            let search = format!("[search]\nmethod = \"{method}\"\ndesigns = 8");
            let all = names(&search);
            // Two times four values: all there are.
            assert_eq!(all.iter().collect::<HashSet<_>>().len(), 8, "{method}");
            assert_eq!(all, names(&search));
        }
        let seeded = |seed: u32| {
            names(&format!("[search]\nmethod = \"random\"\ndesigns = 8\nseed = {seed}"))
        };
        assert_ne!(seeded(1), seeded(2));
    }

    /// The first members of the sequence, as its definition gives them.
    #[test]
    fn halton_points() {
        let inverses = |base| [1, 2, 3, 4, 5].map(|index| radical_inverse(index, base));
        assert_eq!(inverses(2), [0.5, 0.25, 0.75, 0.125, 0.625]);
        let thirds = inverses(3).map(|x| (x * 9.0).round() as u32);
        assert_eq!(thirds, [3, 6, 1, 4, 7]);
        assert_eq!(primes().take(6).collect::<Vec<_>>(), [2, 3, 5, 7, 11, 13]);
    }
}
