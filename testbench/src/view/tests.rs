use super::*;
use crate::golden::primitive::fragments;
use crate::scene::Options;
use pellucid_machine::primitive::Primitive;

fn glass() -> Source {
    let options = Options { width: Some(40), height: Some(30), ..Options::default() };
    Source::open("glass", &options).unwrap()
}

fn primitives(source: &Source) -> Vec<Primitive> {
    let mut primitives = vec![];
    let played = source.play_primitives::<SourceError>(&mut |primitive| {
        primitives.push(primitive);
        Ok(())
    });
    played.unwrap();
    primitives
}

/// A view of primitives that go to the engines that `engine` says.
fn dealt(source: &Source, mut engine: impl FnMut(&Primitive) -> u32 + 'static) -> View {
    let dealer: Dealer = Box::new(move |item| match item {
        Item::Primitive(primitive) => engine(primitive),
        Item::Fragment(_) => panic!("it is a view of primitives"),
    });
    View::new(Kind::Primitives, Some(dealer), source).unwrap()
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
    let mut all: Vec<Fragment> = vec![];
    let played = source.play_fragments::<SourceError>(&mut |fragment| {
        all.push(fragment);
        Ok(())
    });
    played.unwrap();
    let view = View::new(Kind::Fragments, None, &source).unwrap();
    assert_eq!(seen(&view, &source), (all.clone(), all.len() as u64));

    let primitives = primitives(&source);
    let view = View::new(Kind::Primitives, None, &source).unwrap();
    let all = primitives.iter().flat_map(|p| fragments(p, 40)).collect();
    assert_eq!(seen(&view, &source), (all, primitives.len() as u64));
}

/// Three engines by turns: every third opaque primitive is the same engine's.
#[test]
fn opaque_primitives_come_engine_by_engine_before_transparent_ones() {
    let source = glass();
    let primitives = primitives(&source);
    let (opaque, transparent): (Vec<Primitive>, Vec<Primitive>) =
        primitives.iter().copied().partition(|primitive| primitive.opaque);
    assert!(opaque.len() > 9 && transparent.len() > 9);

    let mut turn = 0;
    let view = dealt(&source, move |primitive| {
        turn += u32::from(primitive.opaque);
        turn % 3
    });
    // The first one is engine 1's.
    let of_engine = |first: usize| opaque.iter().skip(first).step_by(3);
    let order = of_engine(2).chain(of_engine(0)).chain(of_engine(1)).chain(&transparent);
    let expected = order.flat_map(|primitive| fragments(primitive, 40)).collect();
    assert_eq!(seen(&view, &source), (expected, primitives.len() as u64));
}

#[test]
fn views_are_equal_where_every_primitive_has_the_same_engine() {
    let source = glass();
    let views = [
        View::new(Kind::Fragments, None, &source).unwrap(),
        View::new(Kind::Primitives, None, &source).unwrap(),
        dealt(&source, |_| 0),
        dealt(&source, |primitive| primitive.row % 2),
    ];
    for (i, view) in views.iter().enumerate() {
        assert_eq!(views.iter().position(|other| other == view), Some(i));
    }
    assert_eq!(views[2], dealt(&source, |_| 0));
}

#[test]
fn engines_are_grouped_as_far_as_their_items_can_be_held() {
    let engines = [0, 2, 2, 3, 3, 3, 5];
    assert_eq!(groups(&engines, 100), [Range { start: 0, end: 6 }]);
    assert_eq!(groups(&engines, 3), [0..3, 3..5, 5..6]);
    assert_eq!(groups(&engines, 1), [0..2, 2..3, 3..4, 4..6]);
    assert_eq!(groups(&[], 1), []);
}
