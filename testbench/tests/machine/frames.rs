//! What the tests of every machine share: random frames, how they are played, and what must hold.

use pellucid_hw::allocator::AllocatorKind;
use pellucid_hw::machine::{Census, Check, Frame, Machine, Tally};
use pellucid_hw::pixel::{Fragment, Marked, Screen, Z_FAR};
use pellucid_sim::block::Cycle;
use pellucid_sim::{Label, Registers, Signals, Sim, Stream};
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::{Golden, Reference};
use pellucid_testbench::image::Image;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scoreboard::Verdict;
use pellucid_testbench::stimulus::chosen;
use pellucid_testbench::window::Window;
use proptest::prelude::*;
use std::fmt::{self, Debug};
use std::path::{Path, PathBuf};

/// Most fragments of a random frame.
pub const FRAGMENTS: usize = 400;
/// Most fragments that are added to one.
pub const ADDED: usize = 30;
/// Places that hold every fragment of a frame, however they are spread.
pub const ENOUGH: u32 = (FRAGMENTS + ADDED) as u32;

/// A machine under test.
pub trait Tested:
    Machine<
        Item = Fragment,
        Config: Copy + Debug,
        State: Registers<Config = Self::Config>,
        Out: Signals<Config = Self::Config>,
    > + 'static
{
    /// Machines in which no fragment of a random frame is dropped.
    fn machines(screen: Screen) -> BoxedStrategy<Self::Config>;
    /// The machine, changed as little as is needed so that none of these frames is too much for it.
    fn fitted(cfg: Self::Config, _: &[Vec<Fragment>]) -> Self::Config {
        cfg
    }
    /// Fragments that resolve works on, one a cycle, and cycles of it without one.
    fn resolved(tally: &Tally) -> [u64; 2];
}

/// A machine and what surrounds it.
pub struct Setup<M: Tested> {
    pub cfg: M::Config,
    /// Of eight cycles, how many the display is not ready in; below 8.
    pub display_busy: u64,
    /// Of eight chances to send, how many the source lets pass; below 8.
    pub source_idle: u64,
}

impl<M: Tested> Clone for Setup<M> {
    fn clone(&self) -> Setup<M> {
        *self
    }
}

impl<M: Tested> Copy for Setup<M> {}

impl<M: Tested> Debug for Setup<M> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Setup { cfg, display_busy, source_idle } = self;
        write!(f, "{cfg:?}, display_busy: {display_busy}, source_idle: {source_idle}")
    }
}

/// What a machine gave for some frames.
pub struct Run {
    pub images: Vec<Image>,
    pub tally: Tally,
}

impl<M: Tested> Setup<M> {
    /// A machine that is never held up.
    pub fn free(cfg: M::Config) -> Setup<M> {
        Setup { cfg, display_busy: 0, source_idle: 0 }
    }

    pub fn screen(&self) -> Screen {
        M::screen(&self.cfg)
    }

    /// Plays the frames on one machine, each next one as soon as the machine takes it.
    pub fn run(&self, frames: &[Vec<Fragment>]) -> Result<Run, BenchError> {
        self.play(frames, None)
    }

    fn play(&self, frames: &[Vec<Fragment>], wave: Option<&WaveJob>) -> Result<Run, BenchError> {
        let mut bench = Bench::<M>::new(self.cfg);
        let (busy, idle) = (self.display_busy, self.source_idle);
        bench.set_display(move |cycle| !chosen(cycle, busy));
        if let Some(wave) = wave {
            bench.record(wave, "machine")?;
        }
        let mut chance = 0;
        bench.traced(|bench| {
            for frame in frames {
                bench.frame(|bench| {
                    for fragment in frame {
                        chance += 1;
                        while chosen(chance, idle) {
                            bench.step(Stream::idle())?;
                            chance += 1;
                        }
                        bench.send(Marked::item(*fragment))?;
                    }
                    Ok(())
                })?;
            }
            bench.wait_for(frames.len(), || {})
        })?;
        Ok(Run { images: bench.take_images(), tally: bench.tally() })
    }

    /// What `judge` says of the frames. If it is not pleased, their waveform is kept, and it is said where.
    pub fn judged(
        &self,
        frames: &[Vec<Fragment>],
        judge: impl FnOnce() -> Result<(), TestCaseError>,
    ) -> Result<(), TestCaseError> {
        judge().map_err(|error| match error {
            TestCaseError::Fail(reason) => {
                let path = kept_at();
                let windows = [Window::Cycles { from: 0, to: u64::MAX }, Window::Failure];
                // A fault of the model is why it is kept.
                let _ = self.play(frames, Some(&WaveJob::new(&path, &windows)));
                TestCaseError::fail(format!("{reason}\nits waveform: {}", path.display()))
            }
            other => other,
        })
    }

    /// What the golden model says of a frame, for this machine's arithmetic.
    pub fn golden(&self, frame: &[Fragment]) -> Reference {
        let mut golden = Golden::new(self.screen()).with(M::ARITHMETIC);
        for fragment in frame {
            golden.push(*fragment).unwrap();
        }
        golden.finish()
    }

    /// The image that the machine must give of a frame.
    pub fn golden_image(&self, frame: &[Fragment]) -> Image {
        self.golden(frame).image_by(M::ARITHMETIC).clone()
    }

    /// The image of one frame, or why there is none.
    pub fn image(&self, frame: &[Fragment]) -> Result<Image, TestCaseError> {
        Ok(tried(self.run(&[frame.to_vec()]))?.images.remove(0))
    }

    /// What the closed forms say of several frames.
    pub fn closed_forms(&self, tally: &Tally, references: &[Reference]) -> Vec<Check> {
        let frames: Vec<Census> = references.iter().map(Reference::census).collect();
        M::closed_forms(&self.cfg, tally, &frames)
    }
}

/// Where the waveform of a test that fails is kept: the test runs in a thread of its name.
pub fn kept_at() -> PathBuf {
    let test = std::thread::current().name().unwrap_or("test").replace("::", "-");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("failures").join(test);
    std::fs::create_dir_all(&folder).unwrap();
    folder.join("wave.vcd")
}

/// Any allocator that can have as many sections as these tests need.
pub fn allocator() -> impl Strategy<Value = AllocatorKind> {
    let kinds = AllocatorKind::ALL.iter().copied();
    prop::sample::select(kinds.filter(|kind| kind.check("", ENOUGH).is_ok()).collect::<Vec<_>>())
}

/// How many random cases are tried: some, or as many as `PROPTEST_CASES` asks for.
pub fn effort() -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    ProptestConfig::with_cases(asked.unwrap_or(128))
}

/// A run's error as a failed case, so that it shrinks.
pub fn tried<T>(result: Result<T, BenchError>) -> Result<T, TestCaseError> {
    result.map_err(|error| TestCaseError::fail(error.to_string()))
}

/// Small screens, and one with several words of occupancy of which the last is not full.
pub fn screens() -> impl Strategy<Value = Screen> {
    let size = prop_oneof![8 => (1..=12u32, 1..=9u32), 1 => Just((67, 5))];
    (size, 0..=0xff_ffffu32).prop_map(|((width, height), background)| Screen {
        width,
        height,
        background,
    })
}

pub fn fragments(screen: Screen) -> impl Strategy<Value = Vec<Fragment>> {
    let depths = prop_oneof![Just(3), Just(40), Just(Z_FAR + 1)];
    depths.prop_flat_map(move |depths| {
        let z = (0..depths).prop_map(move |k| k * (Z_FAR / (depths - 1)));
        let alpha = prop_oneof![
            2 => Just(0), 2 => Just(254), 2 => Just(255), 3 => 1..=253u32
        ];
        let fragment = (0..screen.width, 0..screen.height, z, 0..1u32 << 24, alpha);
        let fragment = fragment.prop_map(|(x, y, z, rgb, a)| Fragment {
            x,
            y,
            z,
            rgba: rgb << 8 | a,
            label: Label::NONE,
        });
        prop::collection::vec(fragment, 0..=FRAGMENTS)
    })
}

/// Machines with what surrounds them.
pub fn setups<M: Tested>() -> impl Strategy<Value = Setup<M>> {
    let machines = screens().prop_flat_map(M::machines);
    (machines, 0..=7u64, 0..=4u64).prop_map(|(cfg, display_busy, source_idle)| Setup {
        cfg,
        display_busy,
        source_idle,
    })
}

/// A machine with one frame.
pub fn one_frame<M: Tested>() -> impl Strategy<Value = (Setup<M>, Vec<Fragment>)> {
    setups::<M>().prop_flat_map(|setup| {
        let frame = fragments(setup.screen());
        frame.prop_map(move |frame| {
            let cfg = M::fitted(setup.cfg, std::slice::from_ref(&frame));
            (Setup { cfg, ..setup }, frame)
        })
    })
}

/// A machine with one to three frames.
pub fn some_frames<M: Tested>() -> impl Strategy<Value = (Setup<M>, Vec<Vec<Fragment>>)> {
    setups::<M>().prop_flat_map(|setup| {
        let frames = prop::collection::vec(fragments(setup.screen()), 1..=3);
        frames.prop_map(move |frames| {
            let cfg = M::fitted(setup.cfg, &frames);
            (Setup { cfg, ..setup }, frames)
        })
    })
}

/// The nearest opaque depth at the pixel of `fragment`.
pub fn opaque_depth(frame: &[Fragment], fragment: &Fragment) -> u32 {
    let same = frame.iter().filter(|f| (f.x, f.y) == (fragment.x, fragment.y));
    same.filter(|f| f.is_opaque()).map(|f| f.z).min().unwrap_or(Z_FAR)
}

/// A machine that is too small drops the fragments for which `dropped` is true, and no other.
pub fn check_drops<M: Tested>(
    setup: &Setup<M>,
    frame: &[Fragment],
    dropped: &[bool],
) -> Result<(), TestCaseError> {
    let kept = frame.iter().zip(dropped).filter(|(_, dropped)| !**dropped);
    let kept: Vec<Fragment> = kept.map(|(fragment, _)| *fragment).collect();
    let count = (frame.len() - kept.len()) as u64;
    let frames = [frame.to_vec()];
    setup.judged(&frames, || {
        let run = tried(setup.run(&frames))?;
        let (kept, all) = (setup.golden(&kept), setup.golden(frame));
        prop_assert_eq!(run.tally.fragments.dropped, count);
        prop_assert_eq!(run.tally.fragments.stored, kept.stored);
        prop_assert_eq!(&run.images[0], kept.image_by(M::ARITHMETIC));
        let forms = setup.closed_forms(&run.tally, std::slice::from_ref(&all));
        let verdict = Verdict::new(&all, M::ARITHMETIC, &run.images[0], &run.tally, forms);
        prop_assert_eq!(verdict.is_right(), count == 0);
        prop_assert!(verdict.is_right_but_for_drops(), "{:?}", verdict.faults());
        Ok(())
    })
}

/// Two machines play a frame again and again, of which one keeps from cycle to cycle only the registers that
/// are declared.
pub fn check_declared<M: Tested>(
    setup: &Setup<M>,
    frame: &[Fragment],
) -> Result<(), TestCaseError> {
    let mut whole = Sim::<M>::new(setup.cfg);
    let mut declared = Sim::<M>::new(setup.cfg);
    let items = frame.iter().map(|f| Marked::item(*f)).chain([Marked::end()]);
    let mut items = items.cycle().peekable();
    for cycle in 0..2000 {
        let fragment = items.peek().map_or(Stream::idle(), |item| Stream::offer(*item));
        let i = Frame { fragment, image_ready: !chosen(cycle, setup.display_busy) };
        let mut taken = false;
        let mut seen = |sim: &mut Sim<M>| {
            let Cycle { cfg, q, out } =
                sim.clock(i).map_err(|e| TestCaseError::fail(e.to_string()))?;
            taken = M::ports(&out).item_ready;
            let mut values = vec![];
            q.sample(cfg, &mut values);
            Signals::sample(&out, cfg, &mut values);
            Ok::<_, TestCaseError>(values)
        };
        prop_assert_eq!(seen(&mut whole)?, seen(&mut declared)?, "in cycle {}", cycle);
        declared.forget_undeclared();
        if taken {
            items.next();
        }
    }
    Ok(())
}

/// Which fragments of a frame find no place in `sections` sections of `capacity` fragments, beside those
/// that the pixels own, if they do.
pub fn without_place(
    screen: Screen,
    frame: &[Fragment],
    sections: u32,
    capacity: u32,
    owned: bool,
) -> Vec<bool> {
    let pixels = screen.pixels() as usize;
    let (mut nearest, mut stored) = (vec![Z_FAR; pixels], vec![0; pixels]);
    let mut free = sections;
    let mut dropped = vec![];
    for f in frame {
        let pixel = (f.y * screen.width + f.x) as usize;
        let visible = f.z < nearest[pixel];
        let mut place = true;
        if visible && f.is_opaque() {
            nearest[pixel] = f.z;
        } else if visible {
            let own = owned && stored[pixel] == 0;
            let full = stored[pixel] % capacity == 0 && !own;
            place = !full || free > 0;
            free -= u32::from(full && place);
            stored[pixel] += u32::from(place);
        }
        dropped.push(!place);
    }
    dropped
}

/// What must hold of every machine.
macro_rules! properties {
    ($machine:ty) => {
        mod properties {
            use super::*;
            use crate::frames::*;
            use pellucid_hw::machine::Machine;
            use pellucid_hw::pixel::{Fragment, Marked, Z_FAR};
            use pellucid_sim::Stream;
            use pellucid_testbench::bench::Bench;
            use pellucid_testbench::golden::Reference;
            use pellucid_testbench::image::Image;
            use pellucid_testbench::scoreboard::Verdict;

            proptest! {
                #![proptest_config(effort())]

                #[test]
                fn random_frames_are_right((setup, frames) in some_frames::<$machine>()) {
                    setup.judged(&frames, || {
                        let references: Vec<_> = frames.iter().map(|f| setup.golden(f)).collect();
                        let run = tried(setup.run(&frames))?;
                        let forms = setup.closed_forms(&run.tally, &references);
                        let (all, image) = (Reference::stacked(&references), Image::stacked(&run.images));
                        let arithmetic = <$machine as Machine>::ARITHMETIC;
                        let verdict = Verdict::new(&all, arithmetic, &image, &run.tally, forms);
                        prop_assert!(verdict.is_right(), "{:?}", verdict.faults());
                        let [worked, idle] = <$machine as Tested>::resolved(&run.tally);
                        prop_assert_eq!(worked + idle, run.tally.cycles.resolve);
                        Ok(())
                    })?;
                }

                /// In the middle of storing, resolving or showing: nothing of that frame is left.
                #[test]
                fn a_reset_at_any_time_leaves_a_clean_machine((setup, frame) in one_frame::<$machine>(), cut in 0u64..1500) {
                    let mut bench = Bench::<$machine>::new(setup.cfg);
                    let mut items = frame.iter().map(|f| Marked::item(*f)).chain([Marked::end()]).peekable();
                    for _ in 0..cut {
                        let offer = items.peek().map_or(Stream::idle(), |item| Stream::offer(*item));
                        if tried(bench.step(offer))? && offer.valid {
                            items.next();
                        }
                    }
                    bench.reset().unwrap();
                    bench.take_images();
                    tried(bench.frame(|bench| {
                        frame.iter().try_for_each(|fragment| bench.send(Marked::item(*fragment)))
                    }))?;
                    tried(bench.wait_for(1, || {}))?;
                    prop_assert_eq!(&bench.take_images()[..], &[setup.golden_image(&frame)]);
                }

                #[test]
                fn the_order_between_pixels_does_not_matter((setup, frame) in one_frame::<$machine>(), seed: u64) {
                    let mut permuted = frame.clone();
                    // A stable sort keeps the order within each pixel.
                    permuted.sort_by_key(|f| {
                        (u64::from(f.y) << 32 | u64::from(f.x)).wrapping_add(seed).wrapping_mul(seed | 1)
                    });
                    setup.judged(std::slice::from_ref(&permuted), || {
                        prop_assert_eq!(setup.image(&frame)?, setup.image(&permuted)?);
                        Ok(())
                    })?;
                }

                #[test]
                fn a_frame_twice_is_the_same_twice((setup, frame) in one_frame::<$machine>()) {
                    let frames = [frame.clone(), frame];
                    setup.judged(&frames, || {
                        let once = tried(setup.run(&frames[..1]))?;
                        let twice = tried(setup.run(&frames))?;
                        prop_assert_eq!(&twice.images[0], &once.images[0]);
                        prop_assert_eq!(&twice.images[1], &once.images[0]);
                        prop_assert_eq!(twice.tally.seed_accesses, 2 * once.tally.seed_accesses);
                        Ok(())
                    })?;
                }

                #[test]
                fn what_lies_behind_opaque_depth_changes_nothing(
                    (setup, frame) in one_frame::<$machine>(),
                    hidden in prop::collection::vec((any::<prop::sample::Index>(), 0..=Z_FAR, any::<u32>()), 0..=ADDED),
                ) {
                    let mut with_hidden = frame.clone();
                    for (place, behind, rgba) in hidden {
                        let at = place.index(with_hidden.len() + 1);
                        let Some(model) = with_hidden.get(at).copied() else { continue };
                        let z = opaque_depth(&frame, &model).saturating_add(behind).min(Z_FAR);
                        // An opaque fragment as deep as the nearest one is hidden only if it comes later.
                        let z = if rgba & 0xff == 0xff { (z + 1).min(Z_FAR) } else { z };
                        with_hidden.insert(at, Fragment { z, rgba, ..model });
                    }
                    setup.judged(std::slice::from_ref(&with_hidden), || {
                        prop_assert_eq!(setup.image(&frame)?, setup.image(&with_hidden)?);
                        Ok(())
                    })?;
                }

                /// All that a machine remembers is in the registers that it declares.
                #[test]
                fn every_register_is_declared((setup, frame) in one_frame::<$machine>()) {
                    check_declared(&setup, &frame)?;
                }

            }
        }
    };
}
pub(crate) use properties;
