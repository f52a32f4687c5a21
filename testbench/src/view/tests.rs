use super::*;
use crate::golden::primitive::fragments;
use crate::scene::Options;

fn glass() -> Source {
    let options = Options { width: Some(40), height: Some(30), ..Options::default() };
    Source::open("glass", &options).unwrap()
}

fn items<T: Played>(source: &Source) -> Vec<T> {
    let mut items = vec![];
    let played = T::play::<SourceError>(source, &mut |item| {
        items.push(item);
        Ok(())
    });
    played.unwrap();
    items
}

fn seen(view: &View, source: &Source) -> (Vec<Fragment>, u64) {
    let mut fragments = vec![];
    let played = view.play::<SourceError>(source, &mut |fragment| {
        fragments.push(fragment);
        Ok(())
    });
    let items = played.unwrap();
    (fragments, items)
}

#[test]
fn without_engines_items_come_as_they_arrive() {
    let source = glass();
    let all: Vec<Fragment> = items(&source);
    let view = View::new::<Fragment>(None, &source).unwrap();
    assert_eq!(seen(&view, &source), (all.clone(), all.len() as u64));

    let primitives: Vec<Primitive> = items(&source);
    let view = View::new::<Primitive>(None, &source).unwrap();
    let all = primitives.iter().flat_map(|p| fragments(p, 40)).collect();
    assert_eq!(seen(&view, &source), (all, primitives.len() as u64));
}

/// Three engines by turns: every third opaque primitive is the same engine's.
#[test]
fn opaque_primitives_come_engine_by_engine_before_transparent_ones() {
    let source = glass();
    let primitives: Vec<Primitive> = items(&source);
    let (opaque, transparent): (Vec<Primitive>, Vec<Primitive>) =
        primitives.iter().copied().partition(|primitive| primitive.opaque);
    assert!(opaque.len() > 9 && transparent.len() > 9);

    let mut turn = 0;
    let by_turns: Dealer<Primitive> = Box::new(move |primitive: &Primitive| {
        turn += u32::from(primitive.opaque);
        turn % 3
    });
    let view = View::new(Some(by_turns), &source).unwrap();
    // The first one is engine 1's.
    let of_engine = |first: usize| opaque.iter().skip(first).step_by(3);
    let order = of_engine(2).chain(of_engine(0)).chain(of_engine(1)).chain(&transparent);
    let expected = order.flat_map(|primitive| fragments(primitive, 40)).collect();
    assert_eq!(seen(&view, &source), (expected, primitives.len() as u64));
}

#[test]
fn views_are_equal_where_every_primitive_has_the_same_engine() {
    let source = glass();
    let one = || -> Option<Dealer<Primitive>> { Some(Box::new(|_| 0)) };
    let by_row: Dealer<Primitive> = Box::new(|primitive| primitive.row % 2);
    let views = [
        View::new::<Fragment>(None, &source).unwrap(),
        View::new::<Primitive>(None, &source).unwrap(),
        View::new(one(), &source).unwrap(),
        View::new(Some(by_row), &source).unwrap(),
    ];
    for (i, view) in views.iter().enumerate() {
        assert_eq!(views.iter().position(|other| other == view), Some(i));
    }
    assert_eq!(views[2], View::new(one(), &source).unwrap());
}

#[test]
fn engines_are_grouped_as_far_as_their_items_can_be_held() {
    let engines = [0, 2, 2, 3, 3, 3, 5];
    assert_eq!(groups(&engines, 100), [Range { start: 0, end: 6 }]);
    assert_eq!(groups(&engines, 3), [0..3, 3..5, 5..6]);
    assert_eq!(groups(&engines, 1), [0..2, 2..3, 3..4, 4..6]);
    assert_eq!(groups(&[], 1), []);
}
