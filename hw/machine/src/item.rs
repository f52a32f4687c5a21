//! What frames are made of, and how a machine is sent it.

use crate::outside;
use crate::pixel::{Fragment, MAX_SIDE, Marked, Screen};
use crate::primitive::{Format, Primitive, span};
use pellucid_sim::{Label, Signals, Stream};

/// What a frame is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Fragments.
    Fragments,
    /// Primitives.
    Primitives,
}

/// A piece of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A fragment.
    Fragment(Fragment),
    /// A primitive.
    Primitive(Primitive),
}

impl From<Fragment> for Item {
    #[inline(always)]
    fn from(fragment: Fragment) -> Item {
        Item::Fragment(fragment)
    }
}

impl From<Primitive> for Item {
    fn from(primitive: Primitive) -> Item {
        Item::Primitive(primitive)
    }
}

impl Item {
    /// Whether all of it hides what lies behind it.
    pub fn is_opaque(&self) -> bool {
        match self {
            Item::Fragment(fragment) => fragment.is_opaque(),
            Item::Primitive(primitive) => primitive.opaque,
        }
    }
}

/// What is offered to a machine in a cycle.
#[derive(Clone, Copy, Debug)]
pub enum Offer<'a> {
    /// Nothing.
    Nothing,
    /// A piece of the frame.
    Item(&'a Item),
    /// The end of the frame.
    End,
}

/// What the widths of a machine's inputs depend on.
#[derive(Clone, Copy, Debug)]
pub struct InConfig {
    /// The screen.
    pub screen: Screen,
    /// The port to outside memory.
    pub outside: outside::Config,
}

/// Inputs of a machine that takes fragments.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(InConfig)]
pub struct FragmentIn {
    /// A frame's fragments in arrival order, then its end.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<Fragment>>,
    /// The display takes a pixel.
    pub image_ready: bool,
    /// What the outside memory shows.
    #[with(cfg.outside)]
    #[exists(cfg.outside.exists())]
    pub outside: outside::In,
}

/// Inputs of a machine that takes primitives.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(InConfig)]
pub struct PrimitiveIn {
    /// A frame's primitives in arrival order, then its end.
    #[with(Format::whole(cfg.screen))]
    pub primitive: Stream<Marked<Primitive>>,
    /// The display takes a pixel.
    pub image_ready: bool,
    /// What the outside memory shows.
    #[with(cfg.outside)]
    #[exists(cfg.outside.exists())]
    pub outside: outside::In,
}

/// A type of items, with the input ports of machines that take them.
pub trait ItemType: Copy + Default {
    /// What they are.
    const KIND: Kind;
    /// Inputs of a machine that takes such items.
    type In: Copy;
    /// The inputs in which `item` is offered, and the outside memory shows that.
    fn input(item: Stream<Marked<Self>>, image_ready: bool, outside: outside::In) -> Self::In;
    /// The item, if it is of this type.
    fn of(item: &Item) -> Option<Self>;
    /// Labels it as number `number` of its frame, counted from 0.
    fn label(&mut self, number: u32);
}

impl ItemType for Fragment {
    const KIND: Kind = Kind::Fragments;
    type In = FragmentIn;

    #[inline(always)]
    fn input(
        fragment: Stream<Marked<Fragment>>,
        image_ready: bool,
        outside: outside::In,
    ) -> FragmentIn {
        FragmentIn { fragment, image_ready, outside }
    }

    #[inline(always)]
    fn of(item: &Item) -> Option<Fragment> {
        if let Item::Fragment(fragment) = item { Some(*fragment) } else { None }
    }

    #[inline(always)]
    fn label(&mut self, number: u32) {
        self.label = Label::new(number, self.x as u16, self.y as u16);
    }
}

/// Its place is where it begins: the first column of its first row.
impl ItemType for Primitive {
    const KIND: Kind = Kind::Primitives;
    type In = PrimitiveIn;

    #[inline(always)]
    fn input(
        primitive: Stream<Marked<Primitive>>,
        image_ready: bool,
        outside: outside::In,
    ) -> PrimitiveIn {
        PrimitiveIn { primitive, image_ready, outside }
    }

    #[inline(always)]
    fn of(item: &Item) -> Option<Primitive> {
        if let Item::Primitive(primitive) = item { Some(*primitive) } else { None }
    }

    #[inline(always)]
    fn label(&mut self, number: u32) {
        let first = span(self.edges, MAX_SIDE).first;
        self.label = Label::new(number, first as u16, self.row as u16);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::{BOUND_BITS, Edge, Side};

    #[test]
    fn items_are_labelled_where_they_begin() {
        let mut fragment = Fragment { x: 4, y: 7, ..Fragment::default() };
        fragment.label(9);
        assert_eq!(fragment.label, Label::new(9, 4, 7));
        // From column 3 on.
        let edge =
            Edge { side: Side::Left, bound: (1 << BOUND_BITS) - 3, height: 1, ..Edge::default() };
        let edges = [edge, Edge::default(), Edge::default()];
        let mut primitive = Primitive { row: 5, last_row: 6, edges, ..Primitive::default() };
        primitive.label(2);
        assert_eq!(primitive.label, Label::new(2, 3, 5));
    }

    #[test]
    fn an_item_is_of_one_type() {
        let fragment = Fragment { x: 4, rgba: 255, ..Fragment::default() };
        let item = Item::from(fragment);
        assert_eq!((Fragment::of(&item), Primitive::of(&item)), (Some(fragment), None));
        let primitive = Primitive { row: 3, ..Primitive::default() };
        let other = Item::from(primitive);
        assert_eq!((Fragment::of(&other), Primitive::of(&other)), (None, Some(primitive)));
        assert!(item.is_opaque() && !other.is_opaque());
    }
}
