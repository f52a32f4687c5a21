use super::*;
use crate::golden;
use crate::test_util::shader;
use pellucid_machine::arithmetic::Unshaded;
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::{Read, Sim};
use proptest::prelude::*;

/// A fragment in place 0.
fn placed(x: u32, y: u32, z: u32, rgba: u32) -> Placed {
    Placed { fragment: Fragment { x, y, z, rgba, ..Fragment::default() }, ..Placed::default() }
}

/// What a pass gives of fragments that come one a cycle, each with the values that the pass before has left.
fn pass(cfg: Config, pass: u32, fragments: &[(Placed, Values)]) -> Vec<(u64, Running)> {
    let mut sim = Sim::<Shader>::new(cfg);
    let mut given = vec![];
    for cycle in 0..fragments.len() as u64 + u64::from(cfg.stages()) {
        let offer = fragments.get(cycle as usize).copied();
        let shaded = sim.moore().shaded;
        given.extend(shaded.valid.then_some((cycle, shaded.payload.item)));
        let i = In {
            fragment: offer.map_or(Stream::idle(), |(item, _)| Stream::offer(Marked::item(item))),
            values: Read { valid: true, data: offer.unwrap_or_default().1 },
            pass,
            advance: true,
        };
        sim.clock(i).unwrap();
    }
    given
}

fn any_fragment() -> impl Strategy<Value = Placed> {
    (0..7u32, 0..5u32, 0..=Z_FAR, any::<u32>())
        .prop_map(|(x, y, z, rgba)| placed(x, y, z, rgba & !1))
}

proptest! {
    /// Pass after pass, with nothing between them but the values: the golden model's colours, which has no passes.
    #[test]
    fn all_passes_are_the_whole_program(
        fragments in prop::collection::vec(any_fragment(), 1..6),
        program in prop::sample::select(vec!["tint", "glass", "sieve", "random"]),
        targets in 1..=MOST_TARGETS,
        bits in prop::sample::select(vec![8, 16, 32]),
        seed: u32,
    ) {
        let kind = crate::program::Kind::ALL.iter().find(|kind| {
            pellucid_machine::params::ParamType::value(**kind).to_string() == program
        });
        let program = Program::new(*kind.unwrap(), seed, targets);
        let cfg = Config { program, targets, bits, ..shader("glass", targets, bits) };
        let mut at_hand: Vec<(Placed, Values)> =
            fragments.iter().map(|placed| (*placed, Values::default())).collect();
        let mut colours = vec![];
        for number in 0..program.count {
            let given = pass(cfg, number, &at_hand);
            prop_assert_eq!(given.len(), fragments.len());
            let colour = |running: Running| (!running.killed).then(|| coloured(&cfg, running).rgba);
            colours = given.iter().map(|(_, running)| colour(*running)).collect();
            at_hand = given.iter().map(|(_, running)| (running.placed, values(&cfg, *running))).collect();
        }
        let expected: Vec<Option<u32>> = fragments
            .iter()
            .map(|Placed { fragment: Fragment { x, y, z, rgba, .. }, .. }| {
                golden::run(&program, bits, Unshaded { x: *x, y: *y, z: *z, rgba: *rgba })
            })
            .collect();
        prop_assert_eq!(colours, expected);
    }
}

#[test]
fn a_fragment_a_cycle_through_as_many_stages_as_the_longest_pass_has_instructions() {
    let fragments = [(placed(1, 1, 7, 0x40), Values::default()); 5];
    for (program, stages) in [("tint", 4), ("glass", 12)] {
        let cycles: Vec<u64> =
            pass(shader(program, 1, 8), 0, &fragments).iter().map(|(cycle, _)| *cycle).collect();
        assert_eq!(cycles, (stages..stages + 5).collect::<Vec<_>>());
    }
}

#[test]
fn an_opaque_fragment_stays_as_it_is() {
    // In the middle of what would be a hole.
    let opaque = (placed(5, 4, 9, 0x10_20_30_ff), Values::default());
    for program in ["glass", "sieve"] {
        let cfg = shader(program, 1, 16);
        let given = pass(cfg, 0, &[opaque]);
        assert_eq!(coloured(&cfg, given[0].1), opaque.0.fragment);
    }
}
