//! Labels: which item it is that a register or a wire holds, for whoever looks at waveforms.
//!
//! A label travels with an item as any other field does, through registers, streams and memories, and is
//! no hardware: it has no bits, no netlist has it, and nothing may depend on it.

use crate::netlist::{Lift, Value};
use crate::signals::{Declare, Misfit, Signals, Sink};
use std::fmt;

/// The label of an item: its number in a frame and its place on the screen. The default labels nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Label {
    /// The number plus 1; 0 for no item. Numbers from `u32::MAX` on have no label.
    after: u32,
    x: u16,
    y: u16,
}

impl Label {
    /// Labels nothing.
    pub const NONE: Label = Label { after: 0, x: 0, y: 0 };

    /// The label of item `number` at column `x` and row `y`.
    pub fn new(number: u32, x: u16, y: u16) -> Label {
        Label { after: number.wrapping_add(1), x, y }
    }
    /// The item's number, if there is an item.
    pub fn number(self) -> Option<u32> {
        self.after.checked_sub(1)
    }
    /// Its column and row.
    pub fn place(self) -> (u16, u16) {
        (self.x, self.y)
    }
}

/// `#number(x,y)`; nothing if there is no item.
impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.number() {
            None => Ok(()),
            Some(number) => write!(f, "#{number}({},{})", self.x, self.y),
        }
    }
}

impl Signals for Label {
    type Config = ();
    fn declare(_: &(), name: &str, to: &mut dyn Declare) {
        to.label(name);
    }
    #[inline(always)]
    fn sample(&self, _: &(), to: &mut impl Sink) {
        to.label(*self);
    }
    #[inline(always)]
    fn fits(&self, _: &()) -> bool {
        true
    }
    fn seek(&self, _: &(), _: &str, _: &mut Misfit) {}
    fn restore(_: &(), _: &mut dyn Iterator<Item = u64>) -> Label {
        Label::NONE
    }
}

impl Lift for Label {
    fn lift(self) -> Value {
        Value::Zero
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::width_of;

    #[test]
    fn a_label_is_a_number_and_a_place_or_nothing() {
        let label = Label::new(7, 3, 1024);
        assert_eq!((label.number(), label.place()), (Some(7), (3, 1024)));
        assert_eq!(label.to_string(), "#7(3,1024)");
        assert_eq!((Label::NONE.number(), Label::NONE.to_string()), (None, String::new()));
        assert_eq!(Label::new(u32::MAX, 0, 0).number(), None);
    }

    #[test]
    fn a_label_is_no_hardware() {
        assert_eq!(width_of::<Label>(&()), 0);
    }
}
