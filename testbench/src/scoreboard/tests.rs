use super::*;
use crate::golden::Golden;
use pellucid_machine::pixel::{Fragment, Screen, rgba};
use pellucid_machine::{Accumulation, Fragments};
use pellucid_mbuffer::golden::WEIGHTED_SUM;
use pellucid_sim::Label;

const SCREEN: Screen = Screen { width: 3, height: 2, background: 0 };
/// A pixel where the exact blend gives 1 and the weighted sum 0, see the golden model's tests.
const APART: (u32, u32) = (1, 0);
const AT: usize = 1;

/// Two layers at one pixel, one at another, nothing at the others.
fn reference() -> Reference {
    let (x, y) = APART;
    let fragments = [
        Fragment { x, y, z: 20, rgba: rgba(1, 1, 1, 128), label: Label::NONE },
        Fragment { x, y, z: 10, rgba: rgba(0, 0, 0, 2), label: Label::NONE },
        Fragment { x: 0, y: 1, z: 5, rgba: rgba(200, 100, 0, 128), label: Label::NONE },
    ];
    Golden::new(SCREEN).with(WEIGHTED_SUM).of(&fragments).unwrap()
}

fn tally(dropped: u64) -> Tally {
    let kept = 3 - dropped;
    let fragments =
        Fragments { arrived: 3, stored: kept, blended: kept, dropped, ..Fragments::default() };
    Tally { fragments, dropped_since: "nothing was free", ..Tally::default() }
}

fn judged(arithmetic: Arithmetic, image: &Image, dropped: u64) -> Verdict {
    Verdict::new(&reference(), arithmetic, image, &tally(dropped), vec![])
}

#[test]
fn each_arithmetic_is_held_to_its_own_image() {
    let reference = reference();
    let blend = judged(Arithmetic::BLEND, reference.image_by(Arithmetic::BLEND), 0);
    assert!(blend.is_right() && blend.is_right_but_for_drops());
    assert_eq!(blend.faults(), [""; 0]);
    assert_eq!(blend.error_bound, 0);
    assert_eq!(
        blend.approval().unwrap(),
        "The image equals the golden model's, bit for bit, and every count its closed form."
    );
    let weights = judged(WEIGHTED_SUM, reference.image_by(WEIGHTED_SUM), 0);
    assert!(weights.is_right() && weights.is_right_but_for_drops());
    assert_eq!(weights.faults(), [""; 0]);
    assert_eq!(weights.image.mismatched_pixels, 1);
    assert_eq!(
        weights.approval().unwrap(),
        "The image equals the golden model of its weighted sum, bit for bit, and every count its closed \
         form. 1 pixels differ from the exact blend, by 1 of 255 at most; its arithmetic allows 1."
    );
}

/// Three frames, of which the last one has the weighted sum's image.
#[test]
fn a_fault_is_told_with_its_frame() {
    let frame = reference();
    let three = Reference::stacked([&frame; 3]);
    assert_eq!((three.fragments, three.layer_histogram[0]), (9, 3 * frame.layer_histogram[0]));
    let tally = || {
        let fragments = Fragments { arrived: 9, stored: 9, blended: 9, ..Fragments::default() };
        Tally { fragments, ..Tally::default() }
    };
    let judged = |last: Arithmetic| {
        let images = [Arithmetic::BLEND, Arithmetic::BLEND, last];
        let image = Image::stacked(images.map(|arithmetic| frame.image_by(arithmetic)));
        Verdict::new(&three, Arithmetic::BLEND, &image, &tally(), vec![]).of_frames(3)
    };
    assert_eq!(
        judged(Arithmetic::BLEND).approval().unwrap(),
        "Each of the 3 images equals the golden model's, bit for bit, and every count its closed form."
    );
    let wrong = judged(WEIGHTED_SUM);
    assert_eq!(
        wrong.faults(),
        ["1 pixels differ from the golden model, by 1 at most, the first at x=1 y=0 of frame 2"]
    );
    assert_eq!(wrong.place(), Some(Window::Pixel { x: 1, y: 0 }));
}

/// Four frames as two images, of which what is found is the first frame of each.
#[test]
fn accumulated_images_are_held_to_their_own_and_to_the_mean() {
    let dark = Golden::new(SCREEN).of(&[]).unwrap();
    let frames = [&dark, &reference(), &reference(), &dark].map(Clone::clone);
    let by = |error_bound| {
        let weights = vec![1, 1];
        Accumulation { name: "first one", weights, channel: Box::new(|of| of[0]), error_bound }
    };
    let fragments = Fragments { arrived: 6, stored: 6, blended: 6, ..Fragments::default() };
    let tally = Tally { fragments, ..Tally::default() };
    let judged = |image: &Image, error_bound| {
        let made = Reference::accumulated(&frames, &by(error_bound));
        Verdict::new(&made, Arithmetic::BLEND, image, &tally, vec![]).of_frames(4)
    };
    let right = Image::stacked([&dark.image, &frames[1].image]);
    // Half of 100 is lost or won, and of the first image half a level, which is rounded up.
    assert_eq!(
        judged(&right, 50).approval().unwrap(),
        "Each of the 2 images equals the golden model of its first one, bit for bit, and every count its closed \
         form. 3 pixels differ from the exact mean, by 50 of 255 at most; its arithmetic allows 50."
    );
    assert_eq!(judged(&right, 50).error_bound, 50);
    let beyond = judged(&right, 49);
    assert_eq!(
        beyond.faults(),
        [
            "2 pixels are farther from the exact mean than the first one allows, by 50 at most, the first at x=0 y=1 of image 0"
        ]
    );
    let mut wrong = right.clone();
    wrong.pixels[6 + AT] ^= 1;
    let verdict = judged(&wrong, 50);
    assert!(!verdict.is_right());
    assert_eq!(
        verdict.faults(),
        [
            "1 pixels differ from the golden model of the first one, by 1 at most, the first at x=1 y=0 of image 1"
        ]
    );
    assert_eq!(verdict.place(), Some(Window::Pixel { x: 1, y: 0 }));
}

#[test]
fn the_exact_blend_is_a_fault_of_a_weighted_sum() {
    let verdict = judged(WEIGHTED_SUM, reference().image_by(Arithmetic::BLEND), 0);
    assert!(!verdict.is_right() && !verdict.is_right_but_for_drops());
    assert_eq!(verdict.approval(), None);
    assert_eq!(verdict.image, Difference::default());
    assert_eq!(
        verdict.faults(),
        [
            "1 pixels differ from the golden model of the weighted sum, by 1 at most, the first at x=1 y=0"
        ]
    );
}

#[test]
fn the_weighted_sum_is_a_fault_of_a_blend() {
    let verdict = judged(Arithmetic::BLEND, reference().image_by(WEIGHTED_SUM), 0);
    assert!(!verdict.is_right());
    assert_eq!(
        verdict.faults(),
        ["1 pixels differ from the golden model, by 1 at most, the first at x=1 y=0"]
    );
}

#[test]
fn a_pixel_beyond_its_bound_is_named() {
    // The weighted sum is 0, the exact blend 1, and 1 is allowed where two layers are.
    let mut image = reference().image_by(WEIGHTED_SUM).clone();
    image.pixels[AT] = 0x000003;
    let verdict = judged(WEIGHTED_SUM, &image, 0);
    assert!(!verdict.is_right() && !verdict.is_right_but_for_drops());
    assert_eq!(
        verdict.faults(),
        [
            "1 pixels differ from the golden model of the weighted sum, by 3 at most, the first at x=1 y=0",
            "1 pixels are farther from the exact blend than the weighted sum allows, by 2 at most, the \
             first at x=1 y=0"
        ]
    );
    // Within the bound it is wrong still.
    image.pixels[AT] = 0x000101;
    let verdict = judged(WEIGHTED_SUM, &image, 0);
    assert!(!verdict.is_right());
    assert_eq!(verdict.beyond, Difference::default());
}

#[test]
fn where_there_is_one_layer_or_none_nothing_is_allowed() {
    for pixel in [2, 3] {
        let mut image = reference().image_by(WEIGHTED_SUM).clone();
        image.pixels[pixel] += 1;
        let first = Some((pixel as u32 % 3, pixel as u32 / 3));
        let beyond = judged(WEIGHTED_SUM, &image, 0).beyond;
        assert_eq!(beyond, Difference { mismatched_pixels: 1, max_error: 1, first });
    }
}

#[test]
fn drops_excuse_the_image_alone() {
    for (arithmetic, how) in [
        (Arithmetic::BLEND, "differ from the golden model"),
        (WEIGHTED_SUM, "differ from the golden model of the weighted sum"),
    ] {
        let mut image = reference().image_by(arithmetic).clone();
        image.pixels[AT] = 0x0000ff;
        let verdict = judged(arithmetic, &image, 1);
        assert!(!verdict.is_right());
        assert!(verdict.is_right_but_for_drops());
        let most = 255 - (reference().image_by(arithmetic).pixels[AT] & 0xff);
        assert_eq!(
            verdict.faults(),
            [format!(
                "1 fragments were dropped, nothing was free; 1 pixels {how}, by {most} at most, the first \
                 at x=1 y=0"
            )]
        );
    }
}

#[test]
fn wrong_counts_are_faults() {
    let form = Check { what: "words read", expected: 7, found: 8 };
    let (reference, arithmetic) = (reference(), WEIGHTED_SUM);
    let image = reference.image_by(arithmetic);
    let verdict = Verdict::new(&reference, arithmetic, image, &tally(0), vec![form]);
    assert!(!verdict.is_right() && !verdict.is_right_but_for_drops());
    assert_eq!(verdict.faults(), ["words read: expected 7, the run counted 8"]);
}

#[test]
fn what_is_wrong_has_a_place() {
    let reference = reference();
    let right = reference.image_by(Arithmetic::BLEND).clone();
    assert_eq!(judged(Arithmetic::BLEND, &right, 0).place(), None);
    let mut wrong = right.clone();
    wrong.pixels[AT] ^= 0x10;
    let (x, y) = APART;
    let pixel = Window::Pixel { x: x as u16, y: y as u16 };
    assert_eq!(judged(Arithmetic::BLEND, &wrong, 0).place(), Some(pixel));
    let dropped = Window::Event { name: "dropped".into() };
    assert_eq!(judged(Arithmetic::BLEND, &wrong, 1).place(), Some(dropped));
}
