//! What must hold of any machine, as properties that random frames try to break.
//!
//! `machine_properties!(ARCHITECTURE)` makes the tests of an architecture; [`frames`] has what they and an architecture's
//! own tests are made of.

pub mod framebuffers;
pub mod frames;
pub mod presets;
pub mod properties;

/// Tests of an architecture: a module `properties`, a test for each property.
#[macro_export]
macro_rules! machine_properties {
    ($arch:expr) => {
        mod properties {
            use super::*;
            $crate::machine_properties!(@each $arch =>
                random_frames_are_right,
                a_reset_at_any_time_leaves_a_clean_machine,
                the_order_between_pixels_does_not_matter,
                a_frame_twice_is_the_same_twice,
                what_lies_behind_opaque_depth_changes_nothing,
                every_register_is_declared,
                what_rests_is_as_if_it_were_clocked,
                the_evaluator_goes_through_frames_as_the_machine_does,
            );
        }
    };
    (@each $arch:expr => $($property:ident,)*) => {
        $(#[test]
        fn $property() {
            $crate::properties::$property($arch);
        })*
    };
}
