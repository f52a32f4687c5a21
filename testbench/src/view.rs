//! What a machine sees of a frame: which fragments the golden model must get for it, and in which order.
//!
//! A machine that takes fragments gets those of the frame in arrival order, and one that takes primitives the fragments
//! of these. A machine with several engines for what is opaque merges their images: of opaque fragments that are equally
//! deep the engine with the lower number wins. For it the opaque items come engine by engine, and the transparent ones,
//! which lie over all of them, at the end.

use crate::source::{Played, Source, SourceError};
use pellucid_hw::machine::Dealer;
use pellucid_hw::pixel::Fragment;
use pellucid_hw::primitive::Primitive;

/// What frames are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Fragments.
    Fragments,
    /// Primitives.
    Primitives,
}

/// How a machine sees a frame. Machines of equal views must give the same image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    kind: Kind,
    /// The engine of each opaque item in arrival order, if there are engines.
    engines: Option<Vec<u32>>,
}

impl View {
    /// The view of machines that take items of type `T` and deal them to engines, if they do.
    ///
    /// # Errors
    /// The frame cannot be read.
    pub fn new<T: Played>(dealer: Option<Dealer<T>>, source: &Source) -> Result<View, SourceError> {
        let Some(mut engine_of) = dealer else {
            return Ok(View { kind: T::KIND, engines: None });
        };
        let mut engines = vec![];
        T::play::<SourceError>(source, &mut |item| {
            let engine = engine_of(&item);
            engines.extend(item.is_opaque().then_some(engine));
            Ok(())
        })?;
        Ok(View { kind: T::KIND, engines: Some(engines) })
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
        match self.kind {
            Kind::Fragments => self.play_items::<Fragment, E>(source, sink),
            Kind::Primitives => self.play_items::<Primitive, E>(source, sink),
        }
    }

    fn play_items<T: Played, E: From<SourceError>>(
        &self,
        source: &Source,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<u64, E> {
        let width = source.screen().width;
        let mut items = 0;
        let mut play = |chosen: &mut dyn FnMut(&T) -> bool| {
            T::play(source, &mut |item| {
                if !chosen(&item) {
                    return Ok(());
                }
                items += 1;
                item.fragments(width).try_for_each(&mut *sink)
            })
        };
        match &self.engines {
            None => play(&mut |_| true)?,
            Some(engines) => {
                for engine in 0..engines.iter().max().map_or(0, |most| most + 1) {
                    let mut of = engines.iter();
                    play(&mut |item| item.is_opaque() && of.next() == Some(&engine))?;
                }
                play(&mut |item| !item.is_opaque())?;
            }
        }
        Ok(items)
    }
}

#[cfg(test)]
mod tests;
