//! What a machine sees of a frame: which fragments the golden model must get for it, and in which order.
//!
//! A machine that takes fragments gets those of the frame in arrival order, and one that takes primitives the fragments
//! of these. A machine with several engines for what is opaque merges their images: of opaque fragments that are equally
//! deep the engine with the lower number wins. For it the opaque items come engine by engine, and the transparent ones,
//! which lie over all of them, at the end.

use crate::golden::primitive;
use crate::source::{Source, SourceError};
use pellucid_machine::pixel::Fragment;
use pellucid_machine::{Dealer, Item, Kind};
use std::ops::Range;

/// How a machine sees a frame. Machines of equal views must give the same image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    kind: Kind,
    /// The engine of each opaque item in arrival order, if there are engines.
    engines: Option<Vec<u32>>,
}

impl View {
    /// The view of machines that take items of this kind and deal them to engines, if they do.
    ///
    /// # Errors
    /// The frame cannot be read.
    pub fn new(kind: Kind, dealer: Option<Dealer>, source: &Source) -> Result<View, SourceError> {
        let Some(mut engine_of) = dealer else { return Ok(View { kind, engines: None }) };
        let mut engines = vec![];
        source.play::<SourceError>(kind, &mut |item| {
            let engine = engine_of(item);
            engines.extend(item.is_opaque().then_some(engine));
            Ok(())
        })?;
        Ok(View { kind, engines: Some(engines) })
    }

    /// Whether it is of the frame's fragments in arrival order.
    pub fn is_of_fragments(&self) -> bool {
        self.kind == Kind::Fragments && self.engines.is_none()
    }

    /// Sends the fragments of the frame; how many items they are of.
    ///
    /// # Errors
    /// As [`Source::play`].
    pub fn play<E: From<SourceError>>(
        &self,
        source: &Source,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<u64, E> {
        let width = source.screen().width;
        let mut items = 0;
        let mut send = |item: &Item| {
            items += 1;
            match item {
                Item::Fragment(fragment) => sink(*fragment),
                Item::Primitive(triangle) => {
                    primitive::fragments(triangle, width).try_for_each(&mut *sink)
                }
            }
        };
        let Some(engines) = &self.engines else {
            source.play(self.kind, &mut send)?;
            return Ok(items);
        };
        for group in groups(engines, HELD) {
            let mut of = engines.iter();
            let mut held = vec![];
            source.play::<E>(self.kind, &mut |item| {
                let engine = if item.is_opaque() { of.next() } else { None };
                match engine.filter(|engine| group.contains(engine)) {
                    // The items of one engine alone come in their order.
                    Some(_) if group.len() == 1 => return send(item),
                    Some(engine) => held.push((*engine, *item)),
                    None => {}
                }
                Ok(())
            })?;
            held.sort_by_key(|(engine, _)| *engine);
            held.iter().try_for_each(|(_, item)| send(item))?;
        }
        let transparent = &mut |item: &Item| if item.is_opaque() { Ok(()) } else { send(item) };
        source.play(self.kind, transparent)?;
        Ok(items)
    }
}

/// Items that are held to be brought into the order of their engines; of a frame with more, the source is played
/// several times.
const HELD: usize = 1 << 20;

/// All engines, in groups of neighbours that together have at most `held` items, or of one that has more.
fn groups(engines: &[u32], held: usize) -> Vec<Range<u32>> {
    let mut counts = vec![0; engines.iter().max().map_or(0, |most| *most as usize + 1)];
    engines.iter().for_each(|engine| counts[*engine as usize] += 1);
    let mut groups: Vec<(Range<u32>, usize)> = vec![];
    for (engine, count) in (0..).zip(counts) {
        match groups.last_mut() {
            Some((group, sum)) if *sum + count <= held => {
                group.end = engine + 1;
                *sum += count;
            }
            _ => groups.push((engine..engine + 1, count)),
        }
    }
    groups.into_iter().map(|(group, _)| group).collect()
}

#[cfg(test)]
mod tests;
