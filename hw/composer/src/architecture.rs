//! What the architecture says of itself.

use crate::Composer;
use crate::config::{self, Behind, PRESETS, Params};
use crate::scan_lines::ScanLines;
use crate::store::{FragmentStore, Store};
use pellucid_blocks::allocator::Chosen;
use pellucid_machine::Architecture;
use pellucid_machine::architecture::{
    Built, Draw, Needs, Parameterised, Setting, about, chosen, one_of,
};
use pellucid_machine::model::Configured;
use pellucid_machine::params::{ParamError, Parameters};
use pellucid_machine::pixel::Screen;
use pellucid_mbuffer::{MBuffer, config as mbuffer};
use pellucid_rbuffer::{RBuffer, config as rbuffer};
use pellucid_tbuffer::{TBuffer, config as tbuffer};

/// See the module's description.
pub static ARCHITECTURE: Architecture = Architecture {
    name: "composer",
    about: "Image composition: engines draw opaque primitives, their images are merged, scan-line engines or a fragment store add the rest",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("scan_line_engines", "3")],
        &[("distribution", "area"), ("beta", "0")],
        &[("transparency", "tbuffer")],
        &[("transparency", "rbuffer")],
        &[("transparency", "mbuffer")],
    ],
    tight: &[
        ("engines", "3"),
        ("primitives", "80"),
        ("line_primitives", "20"),
        ("sorter_depth", "3"),
        ("tbuffer.sections", "40"),
        ("tbuffer.outside_sections", "100"),
        ("rbuffer.overflow", "replay"),
        ("rbuffer.queue", "60"),
        ("mbuffer.overflow_sections", "20"),
        ("mbuffer.outside_sections", "30"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params: Params = chosen(PRESETS, preset, settings)?;
    match params.transparency {
        Behind::ScanLine => {
            let cfg = config::scan_lines(screen, &params)?;
            Ok(Box::new(Configured::<Composer<ScanLines>> { cfg, values: params.values() }))
        }
        Behind::TBuffer => {
            let store = tbuffer::Config::new(screen, params.tbuffer);
            with_store::<TBuffer<Chosen>, tbuffer::Params>(screen, &params, store, "tbuffer")
        }
        Behind::RBuffer => {
            let store = rbuffer::Config::new(screen, params.rbuffer);
            with_store::<RBuffer, rbuffer::Params>(screen, &params, store, "rbuffer")
        }
        Behind::MBuffer => {
            let store = mbuffer::Config::new(screen, params.mbuffer);
            with_store::<MBuffer<Chosen>, mbuffer::Params>(screen, &params, store, "mbuffer")
        }
    }
}

/// The machine with a fragment store, whose parameters `P` are those of `part`.
fn with_store<M: FragmentStore, P: Parameters>(
    screen: Screen,
    params: &Params,
    store: Result<M::Config, ParamError>,
    part: &'static str,
) -> Built {
    let store = store.map_err(|error| error.of_part::<P>(part))?;
    let cfg = config::store(screen, params, store, part)?;
    Ok(Box::new(Configured::<Composer<Store<M>>> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    let mut parameters = vec![
        ("engines", draw(1..=5).to_string()),
        ("distribution", one_of(draw, &["round_robin", "area"]).to_string()),
        ("beta", one_of(draw, &[0, 1, 20, 1023]).to_string()),
        ("set_up_cycles", draw(1..=5).to_string()),
        ("fragment_cycles", draw(1..=3).to_string()),
        ("primitive_queue", draw(1..=5).to_string()),
        ("primitives", needs.fragments.to_string()),
    ];
    match one_of(draw, &["scanline", "tbuffer", "rbuffer", "mbuffer"]) {
        "scanline" => parameters.extend([
            ("line_primitives", needs.fragments.to_string()),
            ("sorter_depth", draw(1..=9).to_string()),
        ]),
        "tbuffer" => parameters.extend([
            ("transparency", "tbuffer".to_string()),
            ("tbuffer.sections", draw(1..=30).to_string()),
            ("tbuffer.outside_sections", needs.fragments.to_string()),
            ("tbuffer.sorter_depth", draw(1..=9).to_string()),
        ]),
        "rbuffer" => parameters.extend([
            ("transparency", "rbuffer".to_string()),
            ("rbuffer.overflow", "replay".to_string()),
            ("rbuffer.queue", draw(2..=30).max(needs.layers).to_string()),
        ]),
        _ => parameters.extend([
            ("transparency", "mbuffer".to_string()),
            ("mbuffer.overflow_sections", draw(0..=30).to_string()),
            ("mbuffer.outside_sections", needs.fragments.to_string()),
        ]),
    }
    parameters
}
