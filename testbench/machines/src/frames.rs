//! Random frames, machines for them, and what surrounds these.

use pellucid_machine::architecture::{Needs, Parameterised, settings};
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine::{Architecture, Census, Check, Model, Tally};
use pellucid_sim::Label;
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::golden::{Golden, Reference};
use pellucid_testbench::image::Image;
use pellucid_testbench::outside::Pausing;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scoreboard::Verdict;
use pellucid_testbench::source::Source;
use pellucid_testbench::stimulus::chosen;
use pellucid_testbench::trial::CaseError;
use pellucid_testbench::view::View;
use pellucid_testbench::window::Window;
use proptest::prelude::*;
use std::fmt::{self, Debug};
use std::path::PathBuf;
use std::sync::Arc;

/// Most fragments of a random frame.
pub const FRAGMENTS: usize = 400;
/// Most fragments that are added to one.
pub const ADDED: usize = 30;
/// Places that hold every fragment of a frame, however they are spread.
pub const ENOUGH: u32 = (FRAGMENTS + ADDED) as u32;

/// A machine and what surrounds it.
#[derive(Clone)]
pub struct Setup {
    /// The machine.
    pub model: Arc<dyn Model>,
    /// Its architecture.
    pub arch: &'static Architecture,
    /// Its parameters, as far as they are not the defaults.
    pub parameters: Parameterised,
    /// Of eight cycles, how many the display is not ready in; below 8.
    pub display_busy: u64,
    /// Of eight chances to send, how many the source lets pass; below 8.
    pub source_idle: u64,
    /// Of eight cycles, in how many the outside memory takes no request; below 8.
    pub memory_busy: u64,
}

impl Debug for Setup {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Screen { width, height, background } = self.screen();
        write!(f, "{} {width}x{height} on {background:06x}", self.arch.name)?;
        for (name, value) in &self.parameters {
            write!(f, " -p {name}={value}")?;
        }
        let Setup { display_busy, source_idle, memory_busy, .. } = self;
        write!(f, ", display_busy: {display_busy}, source_idle: {source_idle}")?;
        write!(f, ", memory_busy: {memory_busy}")
    }
}

/// What a machine gave for some frames.
pub struct Run {
    /// Its images: one for each frame, or for as many as the machine accumulates.
    pub images: Vec<Image>,
    /// What it counted.
    pub tally: Tally,
}

impl Setup {
    /// A machine that is never held up.
    ///
    /// # Panics
    /// It cannot be built.
    #[track_caller]
    pub fn free(arch: &'static Architecture, screen: Screen, parameters: Parameterised) -> Setup {
        let model = arch.build(screen, None, &settings(&parameters));
        let model = Arc::from(model.unwrap_or_else(|error| panic!("{error}")));
        Setup { model, arch, parameters, display_busy: 0, source_idle: 0, memory_busy: 0 }
    }

    /// The same with further parameters.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    #[track_caller]
    pub fn with(&self, further: Parameterised) -> Setup {
        let parameters = self.parameters.iter().cloned().chain(further).collect();
        let Setup { display_busy, source_idle, memory_busy, .. } = *self;
        let free = Setup::free(self.arch, self.screen(), parameters);
        Setup { display_busy, source_idle, memory_busy, ..free }
    }

    /// Its screen.
    pub fn screen(&self) -> Screen {
        self.model.screen()
    }

    /// The value of a parameter.
    ///
    /// # Panics
    /// There is no such parameter, or it is no number.
    pub fn number(&self, name: &str) -> u32 {
        let values = self.model.values();
        let value = values.iter().find(|(known, _)| known == name).map(|(_, value)| value);
        value.and_then(|value| value.to_string().parse().ok()).unwrap_or_else(|| {
            panic!("there is no number `{name}`");
        })
    }

    /// The frames of the image of one frame: that one, as often as the machine accumulates.
    pub fn of_image(&self, frame: &[Fragment]) -> Vec<Vec<Fragment>> {
        vec![frame.to_vec(); self.model.frames_of_image() as usize]
    }

    /// Plays the frames on one machine, each next one as soon as the machine takes it.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn run(&self, frames: &[Vec<Fragment>]) -> Result<Run, BenchError> {
        self.play(frames, None)
    }

    /// The machine at power-up, with its display and its outside memory.
    pub(crate) fn bench(&self) -> Bench {
        let mut bench = Bench::new(&*self.model);
        let busy = self.display_busy;
        bench.set_display(move |cycle| !chosen(cycle, busy));
        if let Some(latency) = self.model.latency() {
            bench.set_timing(Box::new(Pausing::new(latency, self.memory_busy)));
        }
        bench
    }

    fn source(&self, frame: &[Fragment]) -> Source {
        Source::Fragments(self.screen(), frame.to_vec())
    }

    fn play(&self, frames: &[Vec<Fragment>], wave: Option<&WaveJob>) -> Result<Run, BenchError> {
        let mut bench = self.bench();
        let idle = self.source_idle;
        if let Some(wave) = wave {
            bench.record(wave, "machine")?;
        }
        let mut chance = 0;
        bench.traced(|bench| {
            for frame in frames {
                bench.frame(|bench| {
                    self.source(frame).play(self.model.kind(), &mut |item| {
                        chance += 1;
                        while chosen(chance, idle) {
                            bench.pause()?;
                            chance += 1;
                        }
                        bench.send(item)
                    })
                })?;
            }
            bench.wait_for(frames.len() / self.model.frames_of_image() as usize, |_, _| Ok(()))
        })?;
        Ok(Run { images: bench.take_images(), tally: bench.tally() })
    }

    /// What `judge` says of the frames. If it is not pleased, their waveform is kept, and it is said where.
    ///
    /// # Errors
    /// Those of `judge`.
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

    /// What the golden model says of a frame, for this machine's arithmetic and view.
    ///
    /// # Panics
    /// A fragment lies outside the screen.
    pub fn golden(&self, frame: &[Fragment]) -> Reference {
        let golden = Golden::new(self.screen()).with(self.model.arithmetic());
        let source = self.source(frame);
        let view = View::new(self.model.kind(), self.model.dealer(), &source);
        let view = view.unwrap_or_else(|error| panic!("{error}"));
        let judged = golden.judge(|sink| view.play::<CaseError>(&source, sink));
        judged.unwrap_or_else(|error| panic!("{error}")).0
    }

    /// The image that the machine must give of a frame.
    pub fn golden_image(&self, frame: &[Fragment]) -> Image {
        let references = vec![self.golden(frame); self.model.frames_of_image() as usize];
        match self.together(&references).accumulated {
            Some(by) => by.image,
            None => references[0].image_by(self.model.arithmetic()).clone(),
        }
    }

    /// The image of one frame.
    ///
    /// # Errors
    /// There is none.
    pub fn image(&self, frame: &[Fragment]) -> Result<Image, TestCaseError> {
        Ok(tried(self.run(&self.of_image(frame)))?.images.remove(0))
    }

    /// What the closed forms say of several frames.
    pub fn closed_forms(&self, tally: &Tally, references: &[Reference]) -> Vec<Check> {
        let frames: Vec<Census> = references.iter().map(Reference::census).collect();
        self.model.closed_forms(tally, &frames)
    }

    /// What the golden model says of several frames together, and of the images that a machine accumulates of them.
    fn together(&self, references: &[Reference]) -> Reference {
        match self.model.accumulation() {
            Some(by) => Reference::accumulated(references, &by),
            None => Reference::stacked(references),
        }
    }

    /// The verdict on a run of several frames.
    pub fn verdict(&self, run: &Run, references: &[Reference]) -> Verdict {
        let forms = self.closed_forms(&run.tally, references);
        let (all, image) = (self.together(references), Image::stacked(&run.images));
        Verdict::new(&all, self.model.arithmetic(), &image, &run.tally, forms)
    }
}

/// Where the waveform of a test that fails is kept: in `tmp/failures` of the target directory, under the test's name,
/// which its thread has.
///
/// # Panics
/// The folder cannot be made.
pub fn kept_at() -> PathBuf {
    let test = std::thread::current().name().unwrap_or("test").replace("::", "-");
    // The program is in `deps` of a profile's folder.
    let program = std::env::current_exe().unwrap_or_default();
    let target = program.ancestors().nth(3).unwrap_or(&program);
    let folder = target.join("tmp/failures").join(test);
    std::fs::create_dir_all(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    folder.join("wave.vcd")
}

/// How many random cases are tried: some, or as many as `PROPTEST_CASES` asks for.
pub fn effort() -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    ProptestConfig::with_cases(asked.unwrap_or(128))
}

/// A run's error as a failed case, so that it shrinks.
///
/// # Errors
/// The run's.
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

/// Random frames of a screen: few depths or many, every kind of alpha.
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

/// The frames of an image of which a frame is the first: from each that follows other fragments are left out.
fn parts(setup: &Setup, frame: &[Fragment]) -> Vec<Vec<Fragment>> {
    let of_image = setup.model.frames_of_image() as usize;
    let part = |number: usize| {
        let numbered = frame.iter().enumerate();
        let kept = numbered.filter(|(k, _)| number == 0 || k % of_image != number);
        kept.map(|(_, fragment)| *fragment).collect()
    };
    (0..of_image).map(part).collect()
}

/// Random machines of an architecture for one to `most` images, with the frames of these.
pub fn some_frames(
    arch: &'static Architecture,
    most: usize,
) -> impl Strategy<Value = (Setup, Vec<Vec<Fragment>>)> {
    screens().prop_flat_map(move |screen| {
        let frames = prop::collection::vec(fragments(screen), 1..=most);
        let draws = prop::collection::vec(any::<u32>(), 24);
        (frames, draws, 0..=7u64, 0..=4u64, 0..=7u64).prop_map(
            move |(frames, draws, display_busy, source_idle, memory_busy)| {
                let setup = Setup::free(arch, screen, small(arch, &draws, &frames));
                let setup = Setup { display_busy, source_idle, memory_busy, ..setup };
                let frames = frames.iter().flat_map(|frame| parts(&setup, frame)).collect();
                (setup, frames)
            },
        )
    })
}

/// Parameters of a small machine with places for all fragments of these frames, and for as many more as are added.
fn small(arch: &Architecture, draws: &[u32], frames: &[Vec<Fragment>]) -> Parameterised {
    let deepest = frames.iter().flat_map(|frame| {
        let transparent = || frame.iter().filter(|f| !f.is_opaque());
        transparent().map(move |f| transparent().filter(|g| (g.x, g.y) == (f.x, f.y)).count())
    });
    let layers = (deepest.max().unwrap_or_default() + ADDED) as u32;
    let mut draws = draws.iter().cycle();
    let mut draw = |range: std::ops::RangeInclusive<u32>| {
        let number = draws.next().copied().unwrap_or_default();
        range.start() + number % (range.end() - range.start() + 1)
    };
    (arch.small)(&mut draw, Needs { fragments: ENOUGH, layers })
}

/// A random machine with one frame.
pub fn one_frame(arch: &'static Architecture) -> impl Strategy<Value = (Setup, Vec<Fragment>)> {
    some_frames(arch, 1).prop_map(|(setup, mut frames)| (setup, frames.remove(0)))
}

/// The nearest opaque depth at the pixel of `fragment`.
pub fn opaque_depth(frame: &[Fragment], fragment: &Fragment) -> u32 {
    let same = frame.iter().filter(|f| (f.x, f.y) == (fragment.x, fragment.y));
    same.filter(|f| f.is_opaque()).map(|f| f.z).min().unwrap_or(Z_FAR)
}

/// A machine that is too small drops the fragments for which `dropped` is true, and no other.
///
/// # Errors
/// It does not.
pub fn check_drops(
    setup: &Setup,
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
        prop_assert_eq!(&run.images[0], kept.image_by(setup.model.arithmetic()));
        let verdict = setup.verdict(&run, std::slice::from_ref(&all));
        prop_assert_eq!(verdict.is_right(), count == 0);
        prop_assert!(verdict.is_right_but_for_drops(), "{:?}", verdict.faults());
        Ok(())
    })
}

/// Where a table lies, which the parameter `table` says, changes cycles and traffic alone.
///
/// # Errors
/// It changes more.
pub fn check_place(
    setup: &Setup,
    frames: &[Vec<Fragment>],
    table: &'static str,
) -> Result<(), TestCaseError> {
    let run = |place: &str| tried(setup.with(vec![(table, place.to_string())]).run(frames));
    let (on_chip, cached) = (run("on_chip")?, run("cached")?);
    prop_assert!(on_chip.images == cached.images, "another image");
    prop_assert_eq!(on_chip.tally.fragments, cached.tally.fragments);
    prop_assert_eq!(on_chip.tally.seed_accesses, cached.tally.seed_accesses);
    let of_cache =
        |name: &str| ["_hits", "_misses", "_written_back"].iter().any(|of| name.ends_with(of));
    for (on_chip, cached) in on_chip.tally.own.iter().zip(&cached.tally.own) {
        if on_chip.unit != "cycles" && !of_cache(on_chip.name) {
            prop_assert_eq!(on_chip, cached);
        }
    }
    Ok(())
}

/// A frame of which each fragment comes to another line of `line` pixels, and goes once through all of them before it comes to the
/// next pixel of one.
pub fn from_line_to_line(screen: Screen, line: u32) -> Vec<Fragment> {
    let lines = screen.pixels() / line;
    let fragment = |k: u32| {
        let pixel = k % lines * line + k / lines;
        let (x, y) = (pixel % screen.width, pixel / screen.width);
        Fragment { x, y, z: k, rgba: 0x80, label: Label::NONE }
    };
    (0..lines * line).map(fragment).collect()
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
