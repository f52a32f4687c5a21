//! The properties. Each tries random machines of an architecture with random frames, and panics with the smallest that
//! breaks it.

use crate::frames::{ADDED, Setup, effort, one_frame, opaque_depth, some_frames, tried};
use pellucid_machine::dut::{At, Observed, Observer, Quiet};
use pellucid_machine::pixel::{Fragment, Z_FAR};
use pellucid_machine::{Architecture, Dut, Item, Offer};
use pellucid_sim::netlist::Evaluator;
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::Reference;
use pellucid_testbench::source::Source;
use pellucid_testbench::stimulus::chosen;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::fmt::Debug;

/// Tries random values.
///
/// # Panics
/// One of them fails.
fn holds<S: Strategy<Value: Debug>>(of: S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = ProptestConfig { failure_persistence: None, ..effort() };
    if let Err(error) = TestRunner::new(config).run(&of, test) {
        panic!("{error}");
    }
}

/// Images are the golden model's, and every count its closed form.
///
/// # Panics
/// It does not hold.
pub fn random_frames_are_right(arch: &'static Architecture) {
    holds(some_frames(arch, 3), |(setup, frames)| {
        setup.judged(&frames, || {
            let references: Vec<Reference> = frames.iter().map(|f| setup.golden(f)).collect();
            let run = tried(setup.run(&frames))?;
            let verdict = setup.verdict(&run, &references);
            prop_assert!(verdict.is_right(), "{:?}", verdict.faults());
            Ok(())
        })
    });
}

/// The items of a frame, then its end.
fn items(setup: &Setup, frame: &[Fragment]) -> Vec<Option<Item>> {
    let source = Source::Fragments(setup.screen(), frame.to_vec());
    let mut items = vec![];
    let played = source.play::<BenchError>(setup.model.kind(), &mut |item| {
        items.push(Some(*item));
        Ok(())
    });
    played.unwrap_or_else(|error| panic!("{error}"));
    items.push(None);
    items
}

fn offer(item: &Option<Item>) -> Offer<'_> {
    item.as_ref().map_or(Offer::End, Offer::Item)
}

/// In the middle of storing, resolving or showing: nothing of that frame is left.
///
/// # Panics
/// It does not hold.
pub fn a_reset_at_any_time_leaves_a_clean_machine(arch: &'static Architecture) {
    holds((one_frame(arch), 0u64..1500), |((setup, frame), cut)| {
        let mut bench = Bench::new(&*setup.model);
        let items = items(&setup, &frame);
        let mut left = items.iter().peekable();
        for _ in 0..cut {
            let next = left.peek().map_or(Offer::Nothing, |item| offer(item));
            if tried(bench.step(next))? {
                left.next();
            }
        }
        bench.reset();
        bench.take_images();
        for _ in 0..setup.model.frames_of_image() {
            let send =
                |bench: &mut Bench| items.iter().flatten().try_for_each(|item| bench.send(item));
            tried(bench.frame(send))?;
        }
        tried(bench.wait_for(1, |_, _| Ok(())))?;
        prop_assert_eq!(&bench.take_images()[..], &[setup.golden_image(&frame)]);
        Ok(())
    });
}

/// As long as the order within each pixel stays the same. A machine whose engines share the opaque items is left out: who
/// of equally deep ones wins depends on whose they are.
///
/// # Panics
/// It does not hold.
pub fn the_order_between_pixels_does_not_matter(arch: &'static Architecture) {
    holds((one_frame(arch), any::<u64>()), |((setup, frame), seed)| {
        if setup.model.dealer().is_some() {
            return Ok(());
        }
        let mut permuted = frame.clone();
        // A stable sort keeps the order within each pixel.
        permuted.sort_by_key(|f| {
            (u64::from(f.y) << 32 | u64::from(f.x)).wrapping_add(seed).wrapping_mul(seed | 1)
        });
        setup.judged(std::slice::from_ref(&permuted), || {
            prop_assert_eq!(setup.image(&frame)?, setup.image(&permuted)?);
            Ok(())
        })
    });
}

/// Nothing of a frame is left for the next one.
///
/// # Panics
/// It does not hold.
pub fn a_frame_twice_is_the_same_twice(arch: &'static Architecture) {
    holds(one_frame(arch), |(setup, frame)| {
        let once = setup.of_image(&frame);
        let frames = [once.clone(), once.clone()].concat();
        setup.judged(&frames, || {
            let once = tried(setup.run(&once))?;
            let twice = tried(setup.run(&frames))?;
            prop_assert_eq!(&twice.images[0], &once.images[0]);
            prop_assert_eq!(&twice.images[1], &once.images[0]);
            prop_assert_eq!(twice.tally.seed_accesses, 2 * once.tally.seed_accesses);
            Ok(())
        })
    });
}

/// Further fragments that nobody can see change no pixel.
///
/// # Panics
/// It does not hold.
pub fn what_lies_behind_opaque_depth_changes_nothing(arch: &'static Architecture) {
    let hidden = (any::<prop::sample::Index>(), 0..=Z_FAR, any::<u32>());
    let hidden = prop::collection::vec(hidden, 0..=ADDED);
    holds((one_frame(arch), hidden), |((setup, frame), hidden)| {
        let mut with_hidden = frame.clone();
        for (place, behind, rgba) in hidden {
            let at = place.index(with_hidden.len() + 1);
            let Some(model) = with_hidden.get(at).copied() else { continue };
            let z = opaque_depth(&frame, &model).saturating_add(behind).min(Z_FAR);
            // An opaque fragment as deep as the nearest one is hidden only if it comes later.
            let z = if rgba & 0xff == 0xff { (z + 1).min(Z_FAR) } else { z };
            with_hidden.insert(at, Fragment { z, rgba, ..model });
        }
        if setup.model.dealer().is_some() {
            // The others go to other engines then.
            return Ok(());
        }
        setup.judged(std::slice::from_ref(&with_hidden), || {
            prop_assert_eq!(setup.image(&frame)?, setup.image(&with_hidden)?);
            Ok(())
        })
    });
}

/// Keeps what there is to see of the last cycle, and holds the netlist to it, if there is one.
#[derive(Default)]
struct Last {
    values: Vec<u64>,
    evaluator: Option<Evaluator>,
    wrong: Option<String>,
    cycle: u64,
}

impl Observer for Last {
    fn cycle(&mut self, _: At, seen: &dyn Observed) -> Quiet {
        self.values.clear();
        seen.registers(&mut self.values);
        let (mut inputs, mut outputs) = (vec![], vec![]);
        seen.ports(&mut inputs, &mut outputs);
        if let Some(evaluator) = &mut self.evaluator
            && self.wrong.is_none()
        {
            if evaluator.registers() != self.values {
                self.wrong = Some(format!("registers in cycle {}", self.cycle));
            } else if evaluator.evaluate(&inputs) != outputs {
                self.wrong = Some(format!("outputs in cycle {}", self.cycle));
            }
            evaluator.edge();
        }
        self.values.extend(outputs);
        self.cycle += 1;
        Quiet::default()
    }

    fn reset(&mut self) {
        if let Some(evaluator) = &mut self.evaluator {
            evaluator.reset();
        }
    }
}

/// All that a machine remembers is in the registers that it declares: two machines play a frame again and again, of which
/// one keeps from cycle to cycle only these.
///
/// # Panics
/// It does not hold.
pub fn every_register_is_declared(arch: &'static Architecture) {
    holds(one_frame(arch), |(setup, frame)| {
        let items = items(&setup, &frame);
        let mut items = items.iter().cycle().peekable();
        let mut duts = [setup.model.power_up(), setup.model.power_up()];
        for dut in &mut duts {
            let busy = setup.display_busy;
            dut.set_display(Box::new(move |cycle| !chosen(cycle, busy)));
            dut.watch(Box::new(Last::default()));
        }
        for cycle in 0..2000 {
            let mut taken = false;
            let mut seen = |dut: &mut Box<dyn Dut>| -> Result<Vec<u64>, TestCaseError> {
                let next = items.peek().map_or(Offer::Nothing, |item| offer(item));
                let step = dut.step(next).map_err(BenchError::from);
                taken = tried(step)?;
                let last: Option<Box<dyn std::any::Any>> = dut.unwatch().map(|last| last as _);
                let last = last.and_then(|last| last.downcast::<Last>().ok());
                let last = last.unwrap_or_default();
                let values = last.values.clone();
                dut.watch(last);
                Ok(values)
            };
            let [whole, declared] = &mut duts;
            prop_assert_eq!(seen(whole)?, seen(declared)?, "in cycle {}", cycle);
            declared.forget_undeclared();
            if taken {
                items.next();
            }
        }
        Ok(())
    });
}

/// Two frames in a row with stalls, a reset in the first: registers and outputs of the netlist are the machine's.
///
/// # Panics
/// It does not hold.
pub fn the_evaluator_goes_through_frames_as_the_machine_does(arch: &'static Architecture) {
    let config =
        ProptestConfig { cases: effort().cases / 8, failure_persistence: None, ..effort() };
    let test = |(setup, frames): (Setup, Vec<Vec<Fragment>>)| {
        let evaluator = Some(Evaluator::new(&setup.model.netlist()));
        let mut bench = setup.bench();
        bench.watch(Last { evaluator, ..Last::default() });
        let of_frame: Vec<Vec<Option<Item>>> = frames.iter().map(|f| items(&setup, f)).collect();
        let half = of_frame[0].iter().flatten().take(of_frame[0].len() / 2);
        tried(half.into_iter().try_for_each(|item| bench.send(item)))?;
        bench.reset();
        let mut chance = 0;
        for items in &of_frame {
            tried(bench.frame(|bench| {
                items.iter().flatten().try_for_each(|item| {
                    chance += 1;
                    if chosen(chance, setup.source_idle) {
                        bench.pause()?;
                    }
                    bench.send(item)
                })
            }))?;
        }
        let images = frames.len() / setup.model.frames_of_image() as usize;
        tried(bench.wait_for(images, |_, _| Ok(())))?;
        let last = bench.observer::<Last>().unwrap_or_default();
        prop_assert!(last.cycle > 0, "nothing was compared");
        prop_assert_eq!(last.wrong, None);
        Ok(())
    };
    if let Err(error) = TestRunner::new(config).run(&some_frames(arch, 2), test) {
        panic!("{error}");
    }
}

/// What rests is not clocked, and is as if it were: a machine that is watched in every cycle and one that is not show
/// the same in the same cycle, whatever is offered and wherever they are reset, and have counted and stored the same.
///
/// # Panics
/// It does not hold.
pub fn what_rests_is_as_if_it_were_clocked(arch: &'static Architecture) {
    holds((one_frame(arch), 0u64..3000, any::<u64>()), |((setup, frame), cut, when)| {
        let items = items(&setup, &frame);
        let mut left = items.iter().cycle().peekable();
        let mut offers = false;
        let mut benches = [setup.bench(), setup.bench()];
        benches[0].watch(Last::default());
        for cycle in 0..cut + 1500 {
            if cycle == cut {
                benches.iter_mut().for_each(Bench::reset);
                (left, offers) = (items.iter().cycle().peekable(), false);
            }
            // Long pauses and short ones, so that images are shown beside nothing and beside the next frame.
            let pauses = chosen(when.wrapping_add(cycle / 64), 3) || chosen(cycle, 2);
            offers |= !pauses;
            let next = left.peek().filter(|_| offers).map_or(Offer::Nothing, |item| offer(item));
            let mut stepped = vec![];
            for bench in &mut benches {
                let taken = tried(bench.step(next))?;
                stepped.push((taken, bench.dut().phase(), bench.dut().images()));
            }
            prop_assert_eq!(stepped[0], stepped[1], "in cycle {}", cycle);
            if offers && stepped[0].0 {
                left.next();
                offers = false;
            }
        }
        let [mut watched, mut other] = benches;
        prop_assert_eq!(watched.take_images(), other.take_images());
        prop_assert_eq!(watched.tally(), other.tally());
        prop_assert_eq!(words(&mut watched), words(&mut other));
        Ok(())
    });
}

/// All that its memories hold and have under way.
fn words(bench: &mut Bench) -> Vec<u64> {
    let mut words = vec![];
    bench.dut().memories().each(&mut |storage| {
        for addr in 0..storage.info().words {
            storage.peek(addr as u32, &mut words);
        }
        storage.under_way(&mut words);
    });
    words
}
